#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "relief/mesh/topology.h"

/// One step of subdivision: which faces and vertices the finer mesh has, by arithmetic on
/// half-edges; nothing is searched. Source: reverse-subdivision.md sections 2 and 3.2,
/// performance.md section 3.
namespace relief::mesh {

/// How faces are split. A sqrt(3) step puts a vertex into each triangle and flips the old edges;
/// two of them cut each triangle into nine. On the boundary, odd steps leave edges as they are and
/// even ones trisect them: without a boundary both are the same.
enum class Split : std::uint8_t {
    Loop,          ///< triangles into four at the midpoints of edges
    CatmullClark,  ///< polygons into quads at their centres and the midpoints of edges
    Sqrt3Odd,
    Sqrt3Even,
};

struct MeshCounts {
    std::uint64_t vertices = 0;
    std::uint64_t edges = 0;
    std::uint64_t faces = 0;
    std::uint64_t half_edges = 0;
    std::uint64_t boundary_edges = 0;
};
[[nodiscard]] MeshCounts counts_of(const Topology& mesh);
/// After one split.
[[nodiscard]] MeshCounts refined(const MeshCounts& coarse, Split split);

/// Errors: BadInput `too_many_elements`, for half-edges from 2^31 on.
[[nodiscard]] Status check_size(const MeshCounts& counts);

/// The finer mesh. Old vertices keep their numbers; then come the new ones. Loop: that of edge e is
/// vertex_count + e. Catmull-Clark: the same, then vertex_count + edge_count + f for face f.
/// sqrt(3): in the order of faces one each; but in even steps two of a face with a boundary edge
/// from a to b, of which the first is next to a. Faces. Loop: (v0, e0, e2), (v1, e1, e0), (v2, e2,
/// e1), (e0, e1, e2) for face (v0, v1, v2) with the points e_k of the edges (v_k, v_k+1), in the
/// order of faces. Catmull-Clark: corner k of face F gives (F_k, point of edge k, point of F, point
/// of edge k - 1). sqrt(3): for edges in their order, from its smaller to its larger end a to b,
/// (a, R, L) and (b, L, R) with the new points L and R to the left and right; for a boundary edge
/// (a, b, L) in its own direction in odd steps and nothing in even ones, after which follows (p, q,
/// c) for each face (a, b, c) with the boundary edge ab and the points p, q on it. L or R in such a
/// face is the point next to the edge.
///
/// Errors: those of check_split. Complexity: O(n).
[[nodiscard]] Result<Topology> refine(const Topology& coarse, Split split);
/// The same into a mesh that is replaced, in the memory that it has.
[[nodiscard]] Status refine(const Topology& coarse, Split split, Topology& fine);

/// Whether a mesh can be split so. Errors: BadInput `not_triangles` for Loop and sqrt(3) naming the
/// face; `sqrt3_parity` for an even step of a face with two boundary edges; `too_many_elements`.
[[nodiscard]] Status check_split(const Topology& coarse, Split split);

/// How many corners the faces have after a split.
[[nodiscard]] constexpr int sides_after(Split split) {
    return split == Split::CatmullClark ? 4 : 3;
}

/// The corners of the faces of the finer mesh alone: what its `origin` is, in a third of the time
/// and memory. Requires: check_split, room for refined(counts_of(coarse), split).half_edges.
/// Complexity: O(n).
void split_faces(const Topology& coarse, Split split, std::span<Index> corners);

/// Loop and Catmull-Clark: the fine half-edges that a coarse one is cut into, in its direction.
[[nodiscard]] inline std::array<Index, 2> halves(const Topology& coarse, Split split, Index h) {
    const Index next = coarse.next(h);
    if (split == Split::CatmullClark) return {4 * h, 4 * next + 3};
    const Index f = h / 3;
    return {12 * f + 3 * (h % 3), 12 * f + 3 * (next % 3) + 2};
}

/// The new vertices of faces: for Catmull-Clark and sqrt(3) the vertex of face f, or the first of
/// two, is first + f + (the number of faces before it that have two).
struct FacePoints {
    Index first = 0;
    Buffer<Index> of_face;  ///< even steps of meshes with boundary; else empty

    [[nodiscard]] Index operator[](Index f) const {
        return of_face.size() ? of_face[f] : first + f;
    }
};
/// Requires: not Loop.
[[nodiscard]] FacePoints face_points(const Topology& coarse, Split split);

/// sqrt(3): the fine face that begins at half-edge h: (origin, point beyond, point of its own
/// face); on the boundary (origin, target, point of its face) in odd steps, the middle face (p, q,
/// c) in even ones.
[[nodiscard]] Buffer<Index> sqrt3_faces(const Topology& coarse, Split split);

/// The half-edge of a triangle that is on the boundary; kNone: there is none.
[[nodiscard]] Index boundary_side(const Topology& triangles, Index f);

}  // namespace relief::mesh
