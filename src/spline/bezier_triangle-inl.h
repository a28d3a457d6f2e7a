// Bezier triangles for one point (V = float or double) or a vector of points (V = a Highway
// vector). Included once per instruction set.
#if defined(RELIEF_SPLINE_BEZIER_TRIANGLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RELIEF_SPLINE_BEZIER_TRIANGLE_INL_H_
#undef RELIEF_SPLINE_BEZIER_TRIANGLE_INL_H_
#else
#define RELIEF_SPLINE_BEZIER_TRIANGLE_INL_H_
#endif

#include <hwy/highway.h>

#include "relief/spline/box_spline.h"

HWY_BEFORE_NAMESPACE();
namespace relief::spline {
namespace HWY_NAMESPACE {

/// Barycentric coordinates with respect to (0,0), (1,0), (1,1) in the axes (x, y).
template <class V>
struct Barycentric {
    V u;
    V v;
    V w;
};

/// de Casteljau from degree kFrom down to kTo, in place: ordinate (r, s, t) stands at p (p + 1) / 2
/// + t, p = s + t.
template <int kFrom, int kTo, class V>
HWY_INLINE void reduce(V* b, const Barycentric<V>& at) {
    for (int degree = kFrom; degree > kTo; --degree) {
        int k = 0;
        for (int p = 0; p < degree; ++p)
            for (const int end = k + p + 1; k < end; ++k)
                b[k] = at.u * b[k] + at.v * b[k + p + 1] + at.w * b[k + p + 2];
    }
}

/// Value, gradient and Hessian from the ordinates of a triangle (which are overwritten), times
/// `scale`; di, dj are the derivatives along x and y. `set` makes a V of a number.
template <int kDegree, class V, class Set>
HWY_INLINE SurfaceJet<V> triangle_jet(V* b, const Barycentric<V>& at, double scale, Set set) {
    SurfaceJet<V> jet;
    V corner[3];
    if constexpr (kDegree == 1) {
        for (int k = 0; k < 3; ++k) corner[k] = b[k];
        jet.dii = jet.dij = jet.djj = set(0);
    } else {
        reduce<kDegree, 2>(b, at);
        corner[0] = at.u * b[0] + at.v * b[1] + at.w * b[2];
        corner[1] = at.u * b[1] + at.v * b[3] + at.w * b[4];
        corner[2] = at.u * b[2] + at.v * b[4] + at.w * b[5];
        const V second = set(kDegree * (kDegree - 1) * scale);
        jet.dii = second * ((b[3] - b[1]) - (b[1] - b[0]));
        jet.dij = second * ((b[4] - b[3]) - (b[2] - b[1]));
        jet.djj = second * ((b[5] - b[4]) - (b[4] - b[3]));
    }
    const V first = set(kDegree * scale);
    jet.value = set(scale) * (at.u * corner[0] + at.v * corner[1] + at.w * corner[2]);
    jet.di = first * (corner[1] - corner[0]);
    jet.dj = first * (corner[2] - corner[1]);
    return jet;
}

}  // namespace HWY_NAMESPACE
}  // namespace relief::spline
HWY_AFTER_NAMESPACE();

#endif
