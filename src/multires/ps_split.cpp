#include "relief/multires/ps_split.h"

#include <algorithm>
#include <cmath>

#include "multires/ps_crossing.h"
#include "multires/ps_errors.h"

namespace relief::multires::ps {

using mesh::Index;
using mesh::kNone;
using mesh::Triangulation;

namespace {

constexpr double kSmallestWeight = 1e-9;
constexpr double kLopsided = 1e-4;
constexpr double kClosestFoot = 0.1;  ///< to an end of the edge, of its length

Vec2 incentre(const TriangleCorners& v) {
    const double a = length(v[2] - v[1]);
    const double b = length(v[0] - v[2]);
    const double c = length(v[1] - v[0]);
    const double around = a + b + c;
    // Relative to a corner, so that far triangles lose no digits.
    return v[0] + (b / around) * (v[1] - v[0]) + (c / around) * (v[2] - v[0]);
}

/// The weight of `a` in the point of its edge to `b`.
double boundary_weight(BoundaryPoint rule, Vec2 a, Vec2 b, Vec2 centre) {
    if (rule == BoundaryPoint::Midpoint) return 0.5;
    const Vec2 edge = b - a;
    return std::clamp(1 - dot(centre - a, edge) / dot(edge, edge), kClosestFoot, 1 - kClosestFoot);
}

Status take_centres(const Triangulation& mesh, std::span<const Vec2> centres, Split& split) {
    if (centres.size() != mesh.triangles.size())
        return bad_input("size_mismatch: pass one inner point for each of the " +
                         std::to_string(mesh.triangles.size()) + " triangles");
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const Vec2 centre = centres[t] - mesh.origin;
        if (!std::isfinite(centre.x) || !std::isfinite(centre.y))
            return bad_input("non_finite_input: the inner point is not finite",
                             "triangle " + std::to_string(t));
        const auto weights = spline::barycentric(mesh.corners(t), centre);
        if (!(std::min({weights[0], weights[1], weights[2]}) > kSmallestWeight))
            return bad_input(
                "degenerate_split: the inner point is not inside its triangle; move it, or leave "
                "inner points out to have the centres of the incircles",
                "triangle " + std::to_string(t));
        split.centre[t] = centre;
    }
    return {};
}

}  // namespace

Status cross_edges(const Triangulation& mesh, Split& split) {
    const auto not_crossed = first_failure(mesh.edges.size(), [&](Index e) {
        if (mesh.on_boundary(e)) return true;
        const auto [left, right] = mesh.edge_triangles[e];
        const Vec2 lower = mesh.vertex(mesh.edges[e][0]);
        const Vec2 higher = mesh.vertex(mesh.edges[e][1]);
        const double d0 = orient(split.centre[left], split.centre[right], lower);
        const double d1 = orient(split.centre[left], split.centre[right], higher);
        split.edge_weight[e] = d1 / (d1 - d0);
        return (d0 < 0 && d1 > 0) || (d0 > 0 && d1 < 0);
    });
    if (not_crossed < mesh.edges.size())
        return bad_input(
            "edge_not_crossed: the line between the inner points of the two triangles misses the "
            "inside of their edge; choose other inner points, or remove thin triangles",
            "edge " + std::to_string(not_crossed));
    const auto degenerate = first_failure(mesh.edges.size(), [&](Index e) {
        const double weight = split.edge_weight[e];
        return weight >= kSmallestWeight && weight <= 1 - kSmallestWeight;
    });
    if (degenerate < mesh.edges.size())
        return bad_input(
            "degenerate_split: the edge would be cut within 1e-9 of its end; remove the thin "
            "triangles there",
            "edge " + std::to_string(degenerate));
    return {};
}

Result<Split> split(const Triangulation& mesh, const SplitOptions& options) {
    Split split{std::vector<Vec2>(mesh.triangles.size()), std::vector<double>(mesh.edges.size())};
    if (options.centres.empty())
        for_each_index(mesh.triangles.size(),
                       [&](Index t) { split.centre[t] = incentre(mesh.corners(t)); });
    else
        RELIEF_CHECK(take_centres(mesh, options.centres, split));
    for_each_index(mesh.edges.size(), [&](Index e) {
        if (!mesh.on_boundary(e)) return;
        const auto [left, right] = mesh.edge_triangles[e];
        split.edge_weight[e] = boundary_weight(options.boundary, mesh.vertex(mesh.edges[e][0]),
                                               mesh.vertex(mesh.edges[e][1]),
                                               split.centre[left == kNone ? right : left]);
    });
    RELIEF_CHECK(cross_edges(mesh, split));
    return split;
}

std::vector<Index> lopsided_edges(const Split& split) {
    std::vector<Index> edges;
    for (Index e = 0; e < split.edge_weight.size(); ++e)
        if (split.edge_weight[e] < kLopsided || split.edge_weight[e] > 1 - kLopsided)
            edges.push_back(e);
    return edges;
}

}  // namespace relief::multires::ps
