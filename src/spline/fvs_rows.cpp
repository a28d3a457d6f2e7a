#include "spline/fvs_rows.h"

#include <algorithm>

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "spline/fvs_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef RELIEF_SPLINE_FVS_ROWS_ONCE
#define RELIEF_SPLINE_FVS_ROWS_ONCE
namespace relief::spline {

template <class T>
void differences_from(T* out, std::int64_t first, std::int64_t n, T scale,
                      const RowDifference<T>* terms, int count) {
    for (std::int64_t k = first; k < n; ++k) {
        T sum = terms[0].weight * (terms[0].plus[k] - terms[0].minus[k]);
        for (int t = 1; t < count; ++t)
            sum = sum + terms[t].weight * (terms[t].plus[k] - terms[t].minus[k]);
        out[k] = scale * sum;
    }
}

}  // namespace relief::spline
#endif

HWY_BEFORE_NAMESPACE();
namespace relief::spline {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class T>
void differences(T* HWY_RESTRICT out, std::int64_t n, T scale, const RowDifference<T>* terms,
                 int count) {
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto s = hn::Set(d, scale);
    std::int64_t k = 0;
    for (; k + lanes <= n; k += lanes) {
        const auto term = [&](int t) {
            return hn::Mul(hn::Set(d, terms[t].weight), hn::Sub(hn::LoadU(d, terms[t].plus + k),
                                                                hn::LoadU(d, terms[t].minus + k)));
        };
        auto sum = term(0);
        for (int t = 1; t < count; ++t) sum = hn::Add(sum, term(t));
        hn::StoreU(hn::Mul(s, sum), d, out + k);
    }
    differences_from(out, k, n, scale, terms, count);
}

void differences_f(float* o, std::int64_t n, float s, const RowDifference<float>* t, int c) {
    differences(o, n, s, t, c);
}
void differences_d(double* o, std::int64_t n, double s, const RowDifference<double>* t, int c) {
    differences(o, n, s, t, c);
}

}  // namespace HWY_NAMESPACE
}  // namespace relief::spline
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::spline {

#define RELIEF_EXPORT(T, S)                                                              \
    HWY_EXPORT(differences_##S);                                                         \
    template <>                                                                          \
    void row_differences(T* out, std::int64_t n, T scale, const RowDifference<T>* terms, \
                         int count) {                                                    \
        if (count == 0) {                                                                \
            std::fill_n(out, n, T(0));                                                   \
        } else if (simd_enabled()) {                                                     \
            HWY_DYNAMIC_DISPATCH(differences_##S)(out, n, scale, terms, count);          \
        } else {                                                                         \
            differences_from(out, 0, n, scale, terms, count);                            \
        }                                                                                \
    }
RELIEF_EXPORT(float, f)
RELIEF_EXPORT(double, d)
#undef RELIEF_EXPORT

}  // namespace relief::spline
#endif  // HWY_ONCE
