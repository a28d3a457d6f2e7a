#pragma once

#include <cstdint>
#include <vector>

#include "relief/remesh/surface.h"

namespace relief::remesh {

/// Triangles that lose vertices: half-edges as mesh::Topology has them, without numbers of edges.
/// Half-edges of faces that went keep what they were.
struct CollapsingMesh {
    std::vector<mesh::Index> origin;
    std::vector<mesh::Index> twin;
    std::vector<mesh::Index> out;  ///< [vertex]: as mesh::outgoing
    std::vector<std::uint8_t> sharp;

    explicit CollapsingMesh(const Surface& surface);

    static mesh::Index next(mesh::Index h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static mesh::Index prev(mesh::Index h) { return h % 3 == 0 ? h + 2 : h - 1; }
    [[nodiscard]] mesh::Index target(mesh::Index h) const { return origin[next(h)]; }
};

/// The faces at a vertex, counter-clockwise: face i has the corners (vertex, ring[i], ring[i + 1]).
struct Fan {
    mesh::Index vertex = 0;
    bool closed = true;
    std::vector<mesh::Index> spokes;  ///< half-edges that begin at the vertex
    std::vector<mesh::Index> ring;    ///< where they end; on the boundary one more

    void read(const CollapsingMesh& mesh, mesh::Index v);
    /// Begins elsewhere. Requires: closed.
    void rotate(std::size_t first);
    [[nodiscard]] std::size_t after(std::size_t i) const {
        return i + 1 == ring.size() ? 0 : i + 1;
    }
    /// Whether the edge to ring[i] is sharp.
    [[nodiscard]] bool sharp(const CollapsingMesh& mesh, std::size_t i) const {
        return i < spokes.size() ? mesh.sharp[spokes[i]] != 0
                                 : mesh.sharp[CollapsingMesh::prev(spokes.back())] != 0;
    }
};

/// The vertex of a fan goes to ring[target]: its half-edges there join, the faces on both sides of
/// the edge go. Requires: link condition; on the boundary, target is an end of the ring, and there
/// are two faces.
void collapse(CollapsingMesh& mesh, const Fan& fan, std::size_t target);

}  // namespace relief::remesh
