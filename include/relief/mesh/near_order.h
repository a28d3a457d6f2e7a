#pragma once

#include "relief/mesh/topology.h"

/// Meshes numbered so that neighbours are near each other in memory. Source: performance.md section
/// 4.1.
namespace relief::mesh {

/// A mesh in other numbers. Faces begin with the same corners. Edges are counted, but have no
/// numbers: see number_edges.
struct Renumbered {
    Topology mesh;
    Buffer<Index> vertices;  ///< [vertex]: its number so far
    Buffer<Index> faces;     ///< [face]

    /// The number so far of a half-edge.
    [[nodiscard]] Index half_edge(Index h) const {
        const auto sides = static_cast<Index>(mesh.sides);
        return sides * faces[h / sides] + h % sides;
    }
};

/// Faces in the order of a breadth-first search that begins with the first face of each component;
/// vertices as faces name them. Requires: faces of 3 or of 4 sides. Complexity: O(n), of which one
/// visit to each face is in the order of its neighbours, all else in that of memory.
[[nodiscard]] Renumbered near_order(const Topology& mesh);

/// Sets the numbers of edges of a mesh whose twins are there, and their count. Complexity: O(n).
void number_edges(Topology& mesh);

}  // namespace relief::mesh
