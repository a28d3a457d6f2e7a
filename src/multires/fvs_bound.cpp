#include <algorithm>
#include <cmath>
#include <limits>

#include "multires/fvs_functionals.h"
#include "relief/core/parallel.h"

namespace relief::multires::fvs_mesh {

using mesh::Index;
using mesh::Quadrangulation;
using spline::CubicNet;

namespace {

constexpr std::int64_t kGrain = 256;
constexpr double kRounding = 1e-13;

double largest(const CubicNet& net) {
    double most = 0;
    for (const double b : net) {
        if (!std::isfinite(b)) return std::numeric_limits<double>::infinity();
        most = std::max(most, std::abs(b));
    }
    return most;
}

struct Halves {
    CubicNet first;
    CubicNet second;
};

/// De Casteljau at the middle of four ordinates: those of both halves.
struct CurveHalves {
    std::array<double, 4> first;
    std::array<double, 4> second;
};
CurveHalves halve_curve(double b0, double b1, double b2, double b3) {
    const double b01 = 0.5 * (b0 + b1);
    const double b12 = 0.5 * (b1 + b2);
    const double b23 = 0.5 * (b2 + b3);
    const double b012 = 0.5 * (b01 + b12);
    const double b123 = 0.5 * (b12 + b23);
    const double middle = 0.5 * (b012 + b123);
    return {{b0, b01, b012, middle}, {middle, b123, b23, b3}};
}

/// The triangle (A, B, C) cut at the middle M of AB: the nets on (A, M, C) and (M, B, C). Rows of
/// ordinates parallel to AB are cut like curves of degree 3, 2, 1 and 0.
Halves halve(const CubicNet& n) {
    const auto [edge, rest] = halve_curve(n[0], n[1], n[3], n[6]);
    const double b01 = 0.5 * (n[2] + n[4]);
    const double b12 = 0.5 * (n[4] + n[7]);
    const double row = 0.5 * (b01 + b12);
    const double top = 0.5 * (n[5] + n[8]);
    return {{edge[0], edge[1], n[2], edge[2], b01, n[5], edge[3], row, top, n[9]},
            {rest[0], rest[1], row, rest[2], b12, top, rest[3], n[7], n[8], n[9]}};
}

/// The net on (B, C, A) of one on (A, B, C).
CubicNet rotated(const CubicNet& n) {
    return {n[6], n[7], n[3], n[8], n[4], n[1], n[9], n[5], n[2], n[0]};
}

/// Refinement cuts the triangle (A, B, c) of a quad with centre c at the middle M of AB, and the
/// halves at the middles of Ac and Bc: into (A, M, ca), (M, c, ca), (M, B, cb) and (c, M, cb),
/// whose third corners are the centres of the children.
double bound_after(const CubicNet& net, int refinements) {
    if (refinements <= 0) return largest(net);
    const auto [with_a, with_b] = halve(net);
    const Halves at_a = halve(rotated(rotated(with_a)));  // (c, ca, M) and (ca, A, M)
    const Halves at_b = halve(rotated(with_b));           // (B, cb, M) and (cb, c, M)
    double most = 0;
    for (const Halves& halves : {at_a, at_b})
        most = std::max({most, bound_after(rotated(rotated(halves.first)), refinements - 1),
                         bound_after(rotated(halves.second), refinements - 1)});
    return most;
}

double largest_bound(const Quadrangulation& mesh, const NodalData& data, int refinements) {
    const std::vector<double> bounds = quad_bounds(mesh, data, refinements);
    return *std::max_element(bounds.begin(), bounds.end());
}

}  // namespace

std::vector<double> quad_bounds(const Quadrangulation& mesh, const NodalData& data,
                                int refinements) {
    std::vector<double> bounds(mesh.quad_count());
    parallel_for(0, static_cast<std::int64_t>(mesh.quad_count()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (std::int64_t k = first; k < last; ++k) {
                         const auto q = static_cast<Index>(k);
                         const spline::FvsElement element(mesh.corners(q));
                         const auto ordinates = element.ordinates(quad_data(mesh, data, q));
                         for (int i = 0; i < 4; ++i)
                             bounds[q] =
                                 std::max(bounds[q], bound_after(ordinates.net(i), refinements));
                     }
                 });
    return bounds;
}

double error_bound(const Quadrangulation& mesh, const NodalData& a, const NodalData& b,
                   int refinements) {
    NodalData error = a;
    for_each_nodal(
        [](std::vector<double>& difference, const std::vector<double>& other) {
            for (std::size_t k = 0; k < difference.size(); ++k) difference[k] -= other[k];
        },
        error, b);
    const double scale = std::max(largest_bound(mesh, a, 0), largest_bound(mesh, b, 0));
    return largest_bound(mesh, error, refinements) + kRounding * scale;
}

}  // namespace relief::multires::fvs_mesh
