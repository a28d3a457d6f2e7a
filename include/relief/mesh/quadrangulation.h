#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/vec2.h"
#include "relief/mesh/index.h"

/// Quadrangulations of the plane and their refinement through the intersections of the diagonals.
/// Source: fvs-hierarchical.md sections 1, 3 and 11; docs/fvs.md.
namespace relief::mesh {

/// Strictly convex quads in the plane, any two of which share one edge, one vertex or nothing.
/// Invariant: made by `build` or `refine`. Holes, several components, vertices of any valence and
/// quads that touch in one vertex only need no special treatment.
struct Quadrangulation {
    Vec2 origin;            ///< centre of the bounding box of the level that was built
    std::vector<double> x;  ///< vertices relative to the origin: far from zero, nestedness would
    std::vector<double> y;  ///< be lost to rounding
    std::vector<std::array<Index, 4>> quads;             ///< corners, counter-clockwise
    std::vector<std::array<Index, 2>> edges;             ///< from, to
    std::vector<std::array<Index, 4>> quad_edges;        ///< edge of side i, corner i to i + 1
    std::vector<std::array<std::int8_t, 4>> quad_signs;  ///< +1 if the side runs as its edge, or -1

    [[nodiscard]] Index vertex_count() const { return static_cast<Index>(x.size()); }
    [[nodiscard]] Index edge_count() const { return static_cast<Index>(edges.size()); }
    [[nodiscard]] Index quad_count() const { return static_cast<Index>(quads.size()); }

    [[nodiscard]] Vec2 vertex(Index v) const { return {x[v], y[v]}; }
    [[nodiscard]] QuadCorners corners(Index q) const {
        const auto& v = quads[q];
        return {vertex(v[0]), vertex(v[1]), vertex(v[2]), vertex(v[3])};
    }
    /// From the first to the second end of an edge.
    [[nodiscard]] Vec2 edge_vector(Index e) const {
        return vertex(edges[e][1]) - vertex(edges[e][0]);
    }
};

struct BuildOptions {
    bool reorient = false;       ///< turn clockwise quads round instead of refusing them
    bool check_overlap = false;  ///< refuse quads whose interiors meet
};

/// Quads to a quadrangulation. Edges are numbered in the order in which the quads' sides 0 .. 3
/// name them first, and run from their smaller to their larger vertex.
///
/// Errors, all BadInput: the message begins with one of these names, `where` names the element, and
/// the first that applies is reported: `non_finite_vertex` (also beyond 1e150, where areas
/// overflow), `index_out_of_range`, `repeated_vertex`, `clockwise`, `not_strictly_convex` (a corner
/// whose cross product is at most 1e-10 times the squared longest edge of its quad),
/// `edge_used_twice_in_same_direction`, `unused_vertex`, `t_junction` (a vertex within 1e-9 of a
/// boundary edge, relative to its length), `overlap`, `empty_mesh`; and `too_many_elements`.
/// Complexity: O(n log n); check_overlap adds the number of pairs of overlapping bounding boxes.
[[nodiscard]] Result<Quadrangulation> build(std::span<const Vec2> vertices,
                                            std::span<const std::array<Index, 4>> quads,
                                            const BuildOptions& options = {});

/// The same from polygons of any source: polygon k has sizes[k] corners, which follow each other in
/// `corners`. Errors: those above; `not_a_quad` for a polygon of another size than 4 and
/// `size_mismatch` if the sizes do not add up to the number of corners.
[[nodiscard]] Result<Quadrangulation> build_from_polygons(std::span<const Vec2> vertices,
                                                          std::span<const Index> sizes,
                                                          std::span<const Index> corners,
                                                          const BuildOptions& options = {});

/// Each quad into four at the midpoints M_i of its sides and the intersection c of its diagonals.
/// Numbering, with V, E, Q of the parent: vertices: the old, V + e the midpoint of edge e, V + E +
/// q the centre of quad q. Edges: 2e and 2e + 1 the halves of e in its direction, 2E + 4q + i from
/// M_i to c. Quad 4q + i: (v_i, M_i, c, M_(i-1)). Every child is strictly convex. Errors:
/// `level_out_of_range` if the level would have 2^31 edges or more. Complexity: O(n).
[[nodiscard]] Result<Quadrangulation> refine(const Quadrangulation& parent);

struct LevelCounts {
    std::uint64_t vertices = 0;
    std::uint64_t edges = 0;
    std::uint64_t quads = 0;
};

/// How large `level` refinements make the mesh, without refining. Errors: `level_out_of_range` for
/// a negative level or one of 2^31 edges or more.
[[nodiscard]] Result<LevelCounts> level_counts(const Quadrangulation& base, int level);

/// The quads at each vertex, ascending: those of vertex v are quads[first[v]] .. quads[first[v + 1]
/// - 1].
struct VertexQuads {
    std::vector<Index> first;
    std::vector<Index> quads;

    [[nodiscard]] std::span<const Index> of(Index v) const {
        return {quads.data() + first[v], first[v + 1] - first[v]};
    }
};
[[nodiscard]] VertexQuads vertex_quads(const Quadrangulation& mesh);

/// The one or two quads of each edge, the smaller first; the second of a boundary edge is kNoQuad.
inline constexpr Index kNoQuad = kNone;
[[nodiscard]] std::vector<std::array<Index, 2>> edge_quads(const Quadrangulation& mesh);

/// The smallest angle of the quad's four triangles, in degrees. For messages: not the same bits on
/// every machine.
[[nodiscard]] double smallest_angle(const QuadCorners& v);

struct Warning {
    Index quad = 0;
    double degrees = 0;  ///< its smallest angle
    std::string message;
};

/// Quads with an angle of less than 1 degree: legal, but the bounds of the basis functions grow
/// (section 11).
[[nodiscard]] std::vector<Warning> warnings(const Quadrangulation& mesh);

}  // namespace relief::mesh
