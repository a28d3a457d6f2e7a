#include "spline/box_kernels.h"

#include <algorithm>
#include <utility>

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "spline/box_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "spline/bezier_triangle-inl.h"

HWY_BEFORE_NAMESPACE();
namespace relief::spline {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The jet of a triangle from the control points of its window: x is the axis of the larger place
/// in the cell.
template <int kOrder, class T, class V, class Set>
HWY_INLINE SurfaceJet<V> window_jet(const OrdinateSums<T>& sums, const V* controls, V x, V y,
                                    Set set) {
    constexpr int kDegree = degree_of(kOrder);
    constexpr int kOrdinates = ordinate_count(kDegree);
    V b[kOrdinates];
    const auto* term = sums.terms.data();
    const auto* const first = term;
    for (int k = 0; k < kOrdinates; ++k) {
        V sum = set(term->weight) * controls[term->control];
        for (++term; term != first + sums.ends[k]; ++term)
            sum = sum + set(term->weight) * controls[term->control];
        b[k] = sum;
    }
    return triangle_jet<kDegree>(b, Barycentric<V>{set(1) - x, x - y, y}, sums.scale, set);
}

template <int kOrder, class T>
SurfaceJet<T> scalar_jet(const KernelSurface<T>& surface, const T* cell, T fi, T fj) {
    const bool upper = fj > fi;
    const CellIndex<T>* offsets = surface.window(fi, fj);
    T controls[WindowOffsets<T>::kMaxControls];
    for (int k = 0; k < surface.offsets.count; ++k) controls[k] = cell[offsets[k]];
    SurfaceJet<T> jet =
        window_jet<kOrder>(*surface.sums, controls, upper ? fj : fi, upper ? fi : fj,
                           [](double c) { return static_cast<T>(c); });
    if (upper) {
        std::swap(jet.di, jet.dj);
        std::swap(jet.dii, jet.djj);
    }
    return jet;
}

template <int kOrder, class T>
void scalar_jets(const KernelSurface<T>& surface, const CellPoints<T>& points, std::int64_t first,
                 const JetRows<T>& out) {
    for (std::int64_t k = first; k < points.count; ++k)
        store_jet(scalar_jet<kOrder>(surface, surface.corner + points.cell[k], points.fi[k],
                                     points.fj[k]),
                  out, k);
}

template <int kOrder, class T>
void vector_jets(const KernelSurface<T>& surface, const CellPoints<T>& points,
                 const JetRows<T>& out) {
    const hn::ScalableTag<T> d;
    const hn::Rebind<CellIndex<T>, decltype(d)> di;
    using V = hn::Vec<decltype(d)>;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    std::int64_t k = 0;
    for (; k + lanes <= points.count; k += lanes) {
        const V fi = hn::LoadU(d, points.fi + k);
        const V fj = hn::LoadU(d, points.fj + k);
        const auto cell = hn::LoadU(di, points.cell + k);
        const auto upper = hn::Gt(fj, fi);
        const auto upper_index = hn::RebindMask(di, upper);
        V controls[WindowOffsets<T>::kMaxControls];
        for (int n = 0; n < surface.offsets.count; ++n) {
            const auto offset = hn::IfThenElse(upper_index, hn::Set(di, surface.offsets.upper[n]),
                                               hn::Set(di, surface.offsets.lower[n]));
            controls[n] = hn::GatherIndex(d, surface.corner, hn::Add(cell, offset));
        }
        const SurfaceJet<V> jet =
            window_jet<kOrder>(*surface.sums, controls, hn::Max(fi, fj), hn::Min(fi, fj),
                               [d](double c) { return hn::Set(d, static_cast<T>(c)); });
        hn::StoreU(jet.value, d, out.value + k);
        if (out.derivatives >= 1) {
            hn::StoreU(hn::IfThenElse(upper, jet.dj, jet.di), d, out.di + k);
            hn::StoreU(hn::IfThenElse(upper, jet.di, jet.dj), d, out.dj + k);
        }
        if (out.derivatives >= 2) {
            hn::StoreU(hn::IfThenElse(upper, jet.djj, jet.dii), d, out.dii + k);
            hn::StoreU(jet.dij, d, out.dij + k);
            hn::StoreU(hn::IfThenElse(upper, jet.dii, jet.djj), d, out.djj + k);
        }
    }
    scalar_jets<kOrder>(surface, points, k, out);
}

/// Left to the compiler to vectorise: every operation is exact. NaN fails the first comparison.
template <class T>
void locate(const KernelSurface<T>& surface, std::int64_t count, const T* HWY_RESTRICT i,
            const T* HWY_RESTRICT j, CellIndex<T>* HWY_RESTRICT cell, T* HWY_RESTRICT fi,
            T* HWY_RESTRICT fj) {
    for (std::int64_t k = 0; k < count; ++k) {
        const T x = i[k] > 0 ? (i[k] < surface.last_row ? i[k] : surface.last_row) : T(0);
        const T y = j[k] > 0 ? (j[k] < surface.last_col ? j[k] : surface.last_col) : T(0);
        const auto row = static_cast<CellIndex<T>>(x);
        const auto col = static_cast<CellIndex<T>>(y);
        cell[k] = surface.origin + row * surface.stride + col;
        fi[k] = x - static_cast<T>(row);
        fj[k] = y - static_cast<T>(col);
    }
}

template <class T>
void vector_jets_of(const KernelSurface<T>& surface, const CellPoints<T>& points,
                    const JetRows<T>& out) {
    switch (surface.order) {
        case 1:
            return vector_jets<1>(surface, points, out);
        case 2:
            return vector_jets<2>(surface, points, out);
        case 3:
            return vector_jets<3>(surface, points, out);
        default:
            return vector_jets<4>(surface, points, out);
    }
}

#define RELIEF_BOX_KERNELS(T, S)                                                                   \
    void vector_jets_##S(const KernelSurface<T>& s, const CellPoints<T>& p, const JetRows<T>& o) { \
        vector_jets_of(s, p, o);                                                                   \
    }                                                                                              \
    void locate_##S(const KernelSurface<T>& s, std::int64_t n, const T* i, const T* j,             \
                    CellIndex<T>* c, T* fi, T* fj) {                                               \
        locate(s, n, i, j, c, fi, fj);                                                             \
    }
RELIEF_BOX_KERNELS(float, f)
RELIEF_BOX_KERNELS(double, d)
#undef RELIEF_BOX_KERNELS

}  // namespace HWY_NAMESPACE
}  // namespace relief::spline
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::spline {

namespace {

template <class T>
void scalar_jets_of(const KernelSurface<T>& surface, const CellPoints<T>& points,
                    const JetRows<T>& out) {
    switch (surface.order) {
        case 1:
            return HWY_NAMESPACE::scalar_jets<1>(surface, points, 0, out);
        case 2:
            return HWY_NAMESPACE::scalar_jets<2>(surface, points, 0, out);
        case 3:
            return HWY_NAMESPACE::scalar_jets<3>(surface, points, 0, out);
        default:
            return HWY_NAMESPACE::scalar_jets<4>(surface, points, 0, out);
    }
}

}  // namespace

template <class T>
SurfaceJet<T> jet_at(const KernelSurface<T>& surface, const T* cell, T fi, T fj) {
    switch (surface.order) {
        case 1:
            return HWY_NAMESPACE::scalar_jet<1>(surface, cell, fi, fj);
        case 2:
            return HWY_NAMESPACE::scalar_jet<2>(surface, cell, fi, fj);
        case 3:
            return HWY_NAMESPACE::scalar_jet<3>(surface, cell, fi, fj);
        default:
            return HWY_NAMESPACE::scalar_jet<4>(surface, cell, fi, fj);
    }
}

template <class T>
void window_weights(const KernelSurface<T>& surface, double fi, double fj, double* weights) {
    const double x = std::max(fi, fj);
    const double y = std::min(fi, fj);
    const int degree = degree_of(surface.order);
    // Bernstein polynomials by their recursion on the degree, in place from the last to the first.
    double bernstein[ordinate_count(degree_of(kMaxOrder))] = {1};
    for (int n = 1; n <= degree; ++n) {
        for (int p = n; p >= 0; --p) {
            const int row = p * (p + 1) / 2;
            for (int t = p; t >= 0; --t)
                bernstein[row + t] = (p < n ? (1 - x) * bernstein[row + t] : 0) +
                                     (t < p ? (x - y) * bernstein[row - p + t] : 0) +
                                     (t > 0 ? y * bernstein[row - p + t - 1] : 0);
        }
    }
    const OrdinateSums<T>& sums = *surface.sums;
    std::fill_n(weights, surface.offsets.count, 0.0);
    for (int k = 0, term = 0; k < ordinate_count(degree); ++k)
        for (; term < sums.ends[k]; ++term)
            weights[sums.terms[term].control] +=
                sums.terms[term].weight * sums.scale * bernstein[k];
}
template void window_weights(const KernelSurface<float>&, double, double, double*);
template void window_weights(const KernelSurface<double>&, double, double, double*);

#define RELIEF_EXPORT(T, S)                                                                   \
    HWY_EXPORT(vector_jets_##S);                                                              \
    HWY_EXPORT(locate_##S);                                                                   \
    template <>                                                                               \
    void jets_at(const KernelSurface<T>& surface, const CellPoints<T>& points,                \
                 const JetRows<T>& out) {                                                     \
        simd_enabled() ? HWY_DYNAMIC_DISPATCH(vector_jets_##S)(surface, points, out)          \
                       : scalar_jets_of(surface, points, out);                                \
    }                                                                                         \
    template <>                                                                               \
    void locate_points(const KernelSurface<T>& surface, std::int64_t count, const T* i,       \
                       const T* j, CellIndex<T>* cell, T* fi, T* fj) {                        \
        simd_enabled() ? HWY_DYNAMIC_DISPATCH(locate_##S)(surface, count, i, j, cell, fi, fj) \
                       : HWY_NAMESPACE::locate(surface, count, i, j, cell, fi, fj);           \
    }                                                                                         \
    template SurfaceJet<T> jet_at(const KernelSurface<T>&, const T*, T, T);
RELIEF_EXPORT(float, f)
RELIEF_EXPORT(double, d)
#undef RELIEF_EXPORT

}  // namespace relief::spline
#endif  // HWY_ONCE
