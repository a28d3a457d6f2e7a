#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/vec2.h"
#include "relief/mesh/index.h"

/// Triangulations of the plane: what splines of Powell and Sabin live on. Source: powell-sabin.md
/// section 1; docs/triangulations.md.
namespace relief::mesh {

/// Where the triangles of a triangulation are, without how they are joined: 40 bytes a vertex.
struct PlaneTriangles {
    Vec2 origin;            ///< centre of the bounding box of what was built
    std::vector<double> x;  ///< vertices relative to the origin: far from zero, digits that
    std::vector<double> y;  ///< refinement needs would be lost to rounding
    std::vector<std::array<Index, 3>> triangles;  ///< corners, counter-clockwise

    [[nodiscard]] Index vertex_count() const { return static_cast<Index>(x.size()); }
    [[nodiscard]] Index triangle_count() const { return static_cast<Index>(triangles.size()); }

    [[nodiscard]] Vec2 vertex(Index v) const { return {x[v], y[v]}; }
    [[nodiscard]] TriangleCorners corners(Index t) const {
        const auto& v = triangles[t];
        return {vertex(v[0]), vertex(v[1]), vertex(v[2])};
    }
};

/// A side of a triangle: it joins corner `side` to the next one.
struct TriangleSide {
    Index triangle = 0;
    Index side = 0;
};

/// Triangles in the plane, any two of which share one edge, one vertex or nothing. Invariant: made
/// by `build` or `connect`. Holes, several components, vertices of any valence and fans that meet
/// in one vertex only need no special treatment.
struct Triangulation : PlaneTriangles {
    std::vector<std::array<Index, 2>> edges;  ///< lower, higher vertex; lexicographic order
    std::vector<std::array<Index, 2>> edge_triangles;  ///< left and right of lower to higher, kNone
    std::vector<std::array<Index, 3>> triangle_edges;  ///< edge k joins corner k to corner k + 1

    [[nodiscard]] Index edge_count() const { return static_cast<Index>(edges.size()); }
    /// From the lower to the higher vertex.
    [[nodiscard]] Vec2 edge_vector(Index e) const {
        return vertex(edges[e][1]) - vertex(edges[e][0]);
    }
    /// Whether triangle t lies to the left of its edge k, whose lower vertex then is corner k.
    [[nodiscard]] bool runs_forward(Index t, Index k) const {
        return triangles[t][k] < triangles[t][k == 2 ? 0 : k + 1];
    }
    [[nodiscard]] bool on_boundary(Index e) const {
        return edge_triangles[e][0] == kNone || edge_triangles[e][1] == kNone;
    }
    /// The triangle on the other side of edge k of triangle t; kNone on the boundary.
    [[nodiscard]] Index neighbour(Index t, Index k) const {
        return edge_triangles[triangle_edges[t][k]][runs_forward(t, k) ? 1 : 0];
    }
};

struct TriangulationOptions {
    bool strict_orientation = false;  ///< refuse clockwise triangles instead of turning them round
    bool check_overlap = false;       ///< refuse triangles whose interiors meet
};

/// Triangles to a triangulation; their order and that of the vertices stay.
///
/// Errors, all BadInput: the message begins with one of these names, `where` names the element, and
/// the first that applies is reported: `too_many_elements`, `non_finite_input` (also beyond 1e150,
/// where areas overflow), `empty_mesh`, `index_out_of_range`, `repeated_index`, `isolated_vertex`
/// (see `compact`), `degenerate_triangle` (twice the area is at most 1e-12 times the squared
/// longest side), `clockwise` (strict orientation only), `non_manifold_edge` (three triangles),
/// `inconsistent_orientation` (two triangles on one side of an edge), `folded_mesh` (the triangles
/// at a vertex cover a direction twice), `hanging_vertex` (a boundary vertex within 1e-9 of another
/// boundary edge, relative to its length), `overlap`. Triangles that overlap without sharing a
/// vertex or an edge are found by check_overlap only.
/// Complexity: O(n + b log b) with b boundary edges; check_overlap adds O(n log n) and the number
/// of pairs of overlapping bounding boxes.
[[nodiscard]] Result<Triangulation> build(std::span<const Vec2> vertices,
                                          std::span<const std::array<Index, 3>> triangles,
                                          const TriangulationOptions& options = {});

/// The same without any check: for triangles that are known to be right, such as those of a
/// refinement. x and y are relative to the origin. Requires: the triangles are counter-clockwise,
/// name existing vertices, and no two lie on the same side of an edge. Complexity: O(n), with
/// transient memory of 48 bytes a triangle.
[[nodiscard]] Triangulation connect(Vec2 origin, std::vector<double> x, std::vector<double> y,
                                    std::vector<std::array<Index, 3>> triangles);

/// The sides on the boundary, in the order of their edges. Complexity: O(n).
[[nodiscard]] std::vector<TriangleSide> boundary_sides(const Triangulation& mesh);

/// The vertices that triangles use, in their order, and the triangles with their new numbers.
struct CompactTriangles {
    std::vector<Vec2> vertices;
    std::vector<std::array<Index, 3>> triangles;
    std::vector<Index> source;  ///< of each vertex: its number before
};
/// Errors: `index_out_of_range`. Complexity: O(n).
[[nodiscard]] Result<CompactTriangles> compact(std::span<const Vec2> vertices,
                                               std::span<const std::array<Index, 3>> triangles);

/// What lies at each vertex, ascending: at vertex v items[first[v]] .. items[first[v + 1] - 1].
struct VertexStars {
    std::vector<Index> first;
    std::vector<Index> items;

    [[nodiscard]] std::span<const Index> of(Index v) const {
        return {items.data() + first[v], first[v + 1] - first[v]};
    }
};
/// The triangles that have each vertex as a corner. Complexity: O(n).
[[nodiscard]] VertexStars vertex_triangles(const Triangulation& mesh);
/// The vertices that edges join to each vertex. Complexity: O(n).
[[nodiscard]] VertexStars vertex_neighbours(const Triangulation& mesh);

/// The smallest angle in degrees. For messages: not the same bits on every machine.
[[nodiscard]] double smallest_angle(const TriangleCorners& corners);

struct SmallAngle {
    Index triangle = 0;
    double degrees = 0;
    std::string message;  ///< begins with `small_angle`
};

/// Triangles with an angle of less than 1 degree: legal, but roundings of refined splines grow as
/// the triangles get thinner (section 14).
[[nodiscard]] std::vector<SmallAngle> small_angles(const Triangulation& mesh);

}  // namespace relief::mesh
