#pragma once

#include <cstdint>
#include <vector>

#include "relief/spline/jet.h"

/// Box splines M_ddd on the triangular lattice: index (i, j), edges e1 = (1, 0), e2 = (0, 1) and e3
/// = (-1, -1). M_ddd is the d-fold convolution of the hat function M_111 with itself: degree 3d -
/// 2, continuity C^(2d-2), approximation order 2d, support |i|, |j|, |i - j| <= d.
namespace relief::spline {

inline constexpr int kMaxOrder = 4;

[[nodiscard]] constexpr bool valid_order(int order) {
    return order >= 1 && order <= kMaxOrder;
}
[[nodiscard]] constexpr int degree_of(int order) {
    return 3 * order - 2;
}
/// Control points of a Bezier triangle.
[[nodiscard]] constexpr int ordinate_count(int degree) {
    return (degree + 1) * (degree + 2) / 2;
}

/// One entry of a lattice stencil: `weight` at offset (i, j).
struct MaskTap {
    int i = 0;
    int j = 0;
    double weight = 0;
};

/// A control point that reaches the lower triangle (0,0), (1,0), (1,1) of cell (0, 0), and the
/// Bezier ordinates of its basis function there. Ordinate (r, s, t), r + s + t = degree, belongs to
/// the point (s + t, t) / degree and stands at index p (p + 1) / 2 + t with p = s + t.
struct ReachingControl {
    int i = 0;
    int j = 0;
    std::vector<std::int64_t> numerators;  ///< over BoxSpline::denominator
};

/// All that is known of M_ddd, exact up to the final rounding. The upper triangle (0,0), (0,1),
/// (1,1) follows by exchanging i and j.
struct BoxSpline {
    int order = 0;
    int degree = 0;
    std::int64_t denominator = 0;        ///< degree!
    std::vector<ReachingControl> reach;  ///< ascending by (i, j); 3, 12, 27, 48 entries
    std::vector<MaskTap>
        samples;  ///< M_ddd at lattice points, |i|, |j| < order; ascending by (i, j)
    std::vector<MaskTap>
        gram;  ///< integrals of M_ddd times its translates, |i|, |j| < 2 order; unit cells
};

/// The table of order 1 .. kMaxOrder, derived at first use; thread safe.
/// Source: the Bezier nets of box splines by repeated directional integration; for order 2 the
/// table of Loop surfaces.
[[nodiscard]] const BoxSpline& box_spline(int order);

/// Value, gradient and Hessian of the centred M_ddd at any (i, j); zero outside its support.
/// Requires valid_order. On a lattice edge the derivatives that jump there (order 1: the gradient)
/// are those of the lower triangle.
[[nodiscard]] SurfaceJet<double> box_spline_jet(int order, double i, double j);

}  // namespace relief::spline
