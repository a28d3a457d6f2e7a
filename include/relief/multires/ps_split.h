#pragma once

#include <span>
#include <vector>

#include "relief/core/result.h"
#include "relief/mesh/triangulation.h"
#include "relief/spline/ps_element.h"

/// Powell-Sabin splines on triangulations of the plane: the cut of each triangle into six. Source:
/// powell-sabin.md section 2; docs/powell-sabin.md.
namespace relief::multires::ps {

/// Where the pieces of the triangles meet. Invariant: the line from the inner point of a triangle
/// to that of its neighbour crosses their edge at the edge's point.
struct Split {
    std::vector<Vec2> centre;         ///< Z of each triangle, relative to the mesh's origin
    std::vector<double> edge_weight;  ///< of each edge: R = weight V_lower + (1 - weight) V_higher
};

/// The point of an edge that has one triangle only.
enum class BoundaryPoint {
    Foot,      ///< of the perpendicular from Z, its parameter kept in [0.1, 0.9]
    Midpoint,  ///< of the edge
};

struct SplitOptions {
    BoundaryPoint boundary = BoundaryPoint::Foot;
    /// Z of each triangle in the coordinates of the mesh's source; empty: the centres of the
    /// incircles.
    std::span<const Vec2> centres{};
};

/// Errors, all BadInput, `where` names triangle or edge: `size_mismatch` and `non_finite_input` of
/// the given centres; `edge_not_crossed` if the line between two of them misses the edge inside;
/// `degenerate_split` for a centre with a barycentric coordinate of at most 1e-9 or an edge weight
/// outside [1e-9, 1 - 1e-9]. Complexity: O(n).
[[nodiscard]] Result<Split> split(const mesh::Triangulation& mesh,
                                  const SplitOptions& options = {});

/// Edges with a weight outside [1e-4, 1 - 1e-4]: legal, but the pieces at one end are thin.
[[nodiscard]] std::vector<mesh::Index> lopsided_edges(const Split& split);

/// The weight of corner k of triangle t in the point of its edge k.
[[nodiscard]] inline double corner_weight(const mesh::Triangulation& mesh, const Split& split,
                                          mesh::Index t, mesh::Index k) {
    const double weight = split.edge_weight[mesh.triangle_edges[t][k]];
    return mesh.runs_forward(t, k) ? weight : 1 - weight;
}

/// The element of a triangle.
[[nodiscard]] inline spline::PsElement element(const mesh::Triangulation& mesh, const Split& split,
                                               mesh::Index t) {
    return {mesh.corners(t),
            split.centre[t],
            {corner_weight(mesh, split, t, 0), corner_weight(mesh, split, t, 1),
             corner_weight(mesh, split, t, 2)}};
}

/// R of an edge, relative to the mesh's origin.
[[nodiscard]] inline Vec2 edge_point(const mesh::Triangulation& mesh, const Split& split,
                                     mesh::Index e) {
    return mesh.vertex(mesh.edges[e][0]) + (1 - split.edge_weight[e]) * mesh.edge_vector(e);
}

}  // namespace relief::multires::ps
