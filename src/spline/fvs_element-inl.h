// The C1 cubic element on the unit cell for one cell (V = float or double) or a vector of cells (V
// = a Highway vector). Included once per instruction set.
#if defined(RELIEF_SPLINE_FVS_ELEMENT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RELIEF_SPLINE_FVS_ELEMENT_INL_H_
#undef RELIEF_SPLINE_FVS_ELEMENT_INL_H_
#else
#define RELIEF_SPLINE_FVS_ELEMENT_INL_H_
#endif

#include <hwy/highway.h>

#include "spline/bezier_triangle-inl.h"

HWY_BEFORE_NAMESPACE();
namespace relief::spline {
namespace HWY_NAMESPACE {

/// The 25 Bezier ordinates of a cell. Triangle i has the vertices corner i, corner i + 1, centre.
template <class V>
struct CellOrdinates {
    V corner[4];
    V first[4];     ///< on side i, a third from corner i
    V second[4];    ///< on side i, two thirds from corner i
    V spoke[4];     ///< on the diagonal, a third from corner i to the centre
    V inner[4];     ///< in the middle of triangle i
    V diagonal[4];  ///< on the diagonal, two thirds from corner i to the centre
    V centre;
};

/// n: the numbers of a cell in the order of kFvsCell.
template <class V, class Set>
HWY_INLINE CellOrdinates<V> ordinates_of(const V* n, Set set) {
    const V* f = n;
    const V* x = n + 4;
    const V* y = n + 8;
    const V bottom = n[12], right = n[13], top = n[14], left = n[15];
    const V third = set(1 / 3.0), sixth = set(1 / 6.0), twelfth = set(1 / 12.0);
    const V half = set(0.5), four = set(4);
    CellOrdinates<V> b;
    for (int k = 0; k < 4; ++k) b.corner[k] = f[k];
    b.first[0] = f[0] + third * x[0];
    b.second[0] = f[1] - third * x[1];
    b.first[1] = f[1] + third * y[1];
    b.second[1] = f[2] - third * y[2];
    b.first[2] = f[2] - third * x[2];
    b.second[2] = f[3] + third * x[3];
    b.first[3] = f[3] - third * y[3];
    b.second[3] = f[0] + third * y[0];
    b.spoke[0] = f[0] + sixth * (x[0] + y[0]);
    b.spoke[1] = f[1] + sixth * (y[1] - x[1]);
    b.spoke[2] = f[2] - sixth * (x[2] + y[2]);
    b.spoke[3] = f[3] + sixth * (x[3] - y[3]);
    b.inner[0] =
        half * (f[0] + f[1]) + sixth * (x[0] - x[1]) + twelfth * (four * bottom - y[0] - y[1]);
    b.inner[1] =
        half * (f[1] + f[2]) + sixth * (y[1] - y[2]) - twelfth * (four * right - x[1] - x[2]);
    b.inner[2] =
        half * (f[3] + f[2]) + sixth * (x[3] - x[2]) - twelfth * (four * top - y[3] - y[2]);
    b.inner[3] =
        half * (f[0] + f[3]) + sixth * (y[0] - y[3]) + twelfth * (four * left - x[0] - x[3]);
    b.diagonal[0] = half * (b.inner[0] + b.inner[3]);
    b.diagonal[1] = half * (b.inner[0] + b.inner[1]);
    b.diagonal[2] = half * (b.inner[1] + b.inner[2]);
    b.diagonal[3] = half * (b.inner[3] + b.inner[2]);
    b.centre = half * (b.diagonal[0] + b.diagonal[2]);
    return b;
}

/// The jet at (x, y) of the cell, di along y. pick(v0, v1, v2, v3) chooses the value of the
/// triangle that holds the point. Triangle i is turned so that its side lies on the u axis.
template <class V, class Set, class Pick>
HWY_INLINE SurfaceJet<V> cell_jet(const CellOrdinates<V>& b, V x, V y, Set set, Pick pick) {
    const auto of = [&](const V* v) { return pick(v[0], v[1], v[2], v[3]); };
    const auto of_next = [&](const V* v) { return pick(v[1], v[2], v[3], v[0]); };
    V net[10] = {of(b.corner),        of(b.first),    of(b.spoke),       of(b.second),
                 of(b.inner),         of(b.diagonal), of_next(b.corner), of_next(b.spoke),
                 of_next(b.diagonal), b.centre};
    const V one = set(1), two = set(2), zero = set(0);
    const V u = pick(x, y, one - x, one - y);
    const V w = pick(y, one - x, one - y, x);
    const SurfaceJet<V> along =
        triangle_jet<3>(net, Barycentric<V>{one - u - w, u - w, two * w}, 1, set);
    // The axes of the triangle's jet are its side, (1, 0), and the way from its end to the centre,
    // (-1/2, 1/2).
    const V du = along.di;
    const V dw = two * along.dj + du;
    const V duu = along.dii;
    const V duw = two * along.dij + duu;
    const V dww = set(4) * along.djj - duu + two * duw;
    SurfaceJet<V> jet;
    jet.value = along.value;
    jet.dj = pick(du, zero - dw, zero - du, dw);
    jet.di = pick(dw, du, zero - dw, zero - du);
    jet.djj = pick(duu, dww, duu, dww);
    jet.dii = pick(dww, duu, dww, duu);
    jet.dij = pick(duw, zero - duw, duw, zero - duw);
    return jet;
}

}  // namespace HWY_NAMESPACE
}  // namespace relief::spline
HWY_AFTER_NAMESPACE();

#endif
