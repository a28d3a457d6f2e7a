#pragma once

#include <array>
#include <vector>

#include "relief/mesh/quadrangulation.h"
#include "relief/mesh/triangulation.h"

namespace relief::edit {

/// Triangles or quads of the plane as their drawing sees them: cells with `sides` corners,
/// counter-clockwise, of which side i joins corner i to corner i + 1. Numbers are those of the mesh
/// that it was made from.
struct CellMesh {
    std::size_t sides = 0;       ///< 3 or 4
    Vec2 origin;                 ///< of the vertices, in the coordinates of the source
    std::vector<Vec2> vertices;  ///< relative to the origin
    std::vector<std::array<mesh::Index, 4>> cells;       ///< the first `sides` are used
    std::vector<std::array<mesh::Index, 4>> cell_edges;  ///< of side i
    std::vector<std::array<mesh::Index, 2>> edges;
    std::vector<mesh::Index> edge_cell;  ///< the one that an edge is drawn with
    mesh::VertexStars vertex_cells;

    explicit CellMesh(const mesh::Triangulation& mesh);
    explicit CellMesh(const mesh::Quadrangulation& mesh);

    [[nodiscard]] bool runs_forward(mesh::Index cell, std::size_t side) const {
        return edges[cell_edges[cell][side]][0] == cells[cell][side];
    }
    /// The vertices that edges join to `v`, ascending.
    [[nodiscard]] std::vector<mesh::Index> neighbours(mesh::Index v) const;
    /// All cells and edges at some vertices, ascending.
    [[nodiscard]] std::vector<mesh::Index> cells_at(const std::vector<mesh::Index>& some) const;
    [[nodiscard]] std::vector<mesh::Index> edges_at(const std::vector<mesh::Index>& some) const;
    /// All corners of some cells, ascending.
    [[nodiscard]] std::vector<mesh::Index> corners_of(const std::vector<mesh::Index>& some) const;
};

/// Ascending and each once, from numbers below `end`. Complexity: O(n log n) for few, O(n) for
/// many.
void sort_unique(std::vector<mesh::Index>& numbers, std::size_t end);
/// What is in at least one of two lists that are ascending.
[[nodiscard]] std::vector<mesh::Index> merged(const std::vector<mesh::Index>& a,
                                              const std::vector<mesh::Index>& b);

}  // namespace relief::edit
