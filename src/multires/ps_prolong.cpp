#include "multires/ps_errors.h"
#include "multires/ps_step.h"

namespace relief::multires::ps {

using mesh::Index;
using mesh::kNone;
using spline::TangentPlane;

namespace {

/// The edge of a fine vertex beyond those of vertices and triangles, and its end that is nearer.
struct EdgeVertex {
    Index edge = 0;
    int end = 0;
};
EdgeVertex edge_vertex(const Space& coarse, Scheme scheme, Index fine) {
    const Index n = coarse.mesh.vertex_count();
    if (scheme == Scheme::Dyadic) return {fine - n, 0};
    const Index local = fine - n - coarse.mesh.triangle_count();
    return {local / 2, static_cast<int>(local % 2)};
}

/// At Z: the ordinates halfway to the corners.
Anchors centre_anchors(const Space& coarse, Index t, const std::array<TangentPlane, 3>& planes) {
    Anchors result;
    const TriangleCorners v = coarse.mesh.corners(t);
    for (int k = 0; k < 3; ++k) {
        const Vec2 way = 0.5 * (coarse.split.centre[t] - v[k]);
        result.point[k] = -1 * way;
        result.height[k] = planes[k].at(way);
    }
    return result;
}

/// Between vertex i and R of the edge to j, or at R (mu is the weight of V_i in the new vertex): on
/// the edge the ordinate halfway to V_i; beside it, halfway to a point P of the line Z R Z', the
/// mean of those halfway from V_i and V_j to P, all of which lie on one plane.
Anchors edge_anchors(const Space& coarse, Index e, int end, double mu, Vec2 position,
                     const TangentPlane& near, const TangentPlane& far) {
    const Vec2 vi = coarse.mesh.vertex(coarse.mesh.edges[e][end]);
    const Vec2 vj = coarse.mesh.vertex(coarse.mesh.edges[e][1 - end]);
    Anchors result;
    result.point[0] = 0.5 * (vi - position);
    result.height[0] = near.at(0.5 * (position - vi));
    for (int side = 0; side < 2; ++side) {
        const Index t = coarse.mesh.edge_triangles[e][side];
        const Vec2 p =
            t == kNone ? edge_point(coarse.mesh, coarse.split, e) : coarse.split.centre[t];
        result.point[side + 1] = 0.5 * (p - position);
        result.height[side + 1] = mu * near.at(0.5 * (p - vi)) + (1 - mu) * far.at(0.5 * (p - vj));
    }
    return result;
}

/// The planes at the stencil of a fine vertex to the heights of its control triangle.
Heights fine_heights(const Space& coarse, const Refinement& step, Index fine,
                     const std::array<TangentPlane, 3>& planes) {
    const TriangleCorners& control = step.fine.control[fine];
    if (fine < coarse.mesh.vertex_count()) return heights(control, planes[0]);
    const Anchors known =
        anchors(coarse, step.scheme, step.kappa, fine, step.fine.mesh.vertex(fine), planes);
    Heights result;
    for (int j = 0; j < 3; ++j) {
        const std::array<double, 3> weight = spline::barycentric(known.point, control[j]);
        result[j] =
            weight[0] * known.height[0] + weight[1] * known.height[1] + weight[2] * known.height[2];
    }
    return result;
}

}  // namespace

StepStencil step_stencil(const Space& coarse, Scheme scheme, Index fine) {
    const Index n = coarse.mesh.vertex_count();
    if (fine < n) return {1, {fine}};
    if (scheme != Scheme::Dyadic && fine - n < coarse.mesh.triangle_count())
        return {3, coarse.mesh.triangles[fine - n]};
    const auto [edge, end] = edge_vertex(coarse, scheme, fine);
    return {2, {coarse.mesh.edges[edge][end], coarse.mesh.edges[edge][1 - end]}};
}

Anchors anchors(const Space& coarse, Scheme scheme, std::span<const double> kappa, Index fine,
                Vec2 position, const std::array<TangentPlane, 3>& planes) {
    const Index n = coarse.mesh.vertex_count();
    if (scheme != Scheme::Dyadic && fine - n < coarse.mesh.triangle_count())
        return centre_anchors(coarse, fine - n, planes);
    const auto [e, end] = edge_vertex(coarse, scheme, fine);
    const double weight = end == 0 ? coarse.split.edge_weight[e] : 1 - coarse.split.edge_weight[e];
    const double part = scheme == Scheme::Dyadic ? 1 : kappa[coarse.mesh.edges[e][end]];
    return edge_anchors(coarse, e, end, 1 - part * (1 - weight), position, planes[0], planes[1]);
}

Coefficients prolong(const Space& coarse, const Refinement& step, std::span<const Heights> spline) {
    const TangentPlanes known = tangent_planes(coarse, spline);
    Coefficients fine(step.fine.mesh.vertex_count());
    for_each_index(fine.size(), [&](Index v) {
        const StepStencil stencil = step_stencil(coarse, step.scheme, v);
        std::array<TangentPlane, 3> planes{};
        for (int k = 0; k < stencil.count; ++k) planes[k] = known[stencil.vertex[k]];
        fine[v] = fine_heights(coarse, step, v, planes);
    });
    return fine;
}

StepRows step_rows(const Space& coarse, const Refinement& step, Index fine) {
    const StepStencil stencil = step_stencil(coarse, step.scheme, fine);
    StepRows rows{stencil.count, stencil.vertex, {}};
    for (int k = 0; k < stencil.count; ++k) {
        const auto basis = basis_planes(coarse.control[stencil.vertex[k]]);
        for (int l = 0; l < 3; ++l) {
            std::array<TangentPlane, 3> planes{};
            planes[k] = basis[l];
            const Heights column = fine_heights(coarse, step, fine, planes);
            for (int j = 0; j < 3; ++j) rows.block[k][j][l] = column[j];
        }
    }
    return rows;
}

Coefficients transpose_prolong(const Space& coarse, const Refinement& step,
                               std::span<const Heights> fine) {
    Coefficients sum(coarse.mesh.vertex_count());
    for (Index v = 0; v < fine.size(); ++v) {
        const StepRows rows = step_rows(coarse, step, v);
        for (int k = 0; k < rows.count; ++k)
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l)
                    sum[rows.vertex[k]][l] += rows.block[k][j][l] * fine[v][j];
    }
    return sum;
}

}  // namespace relief::multires::ps
