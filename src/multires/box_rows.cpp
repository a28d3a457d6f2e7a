#include "multires/box_rows.h"

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "multires/box_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace relief::multires::box {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class T>
using Six = std::array<const T*, 6>;
template <class T>
using Four = std::array<const T*, 4>;

template <class D, class T>
HWY_INLINE hn::Vec<D> sum_of_two(D d, const T* a, const T* b) {
    return hn::Add(hn::LoadU(d, a), hn::LoadU(d, b));
}

template <class T>
void step(T centre, T ring, const T* v, const Six<T>& r, std::int64_t n, T* out) {
    const auto [r0, r1, r2, r3, r4, r5] = r;
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto c = hn::Set(d, centre);
    const auto w = hn::Set(d, ring);
    std::int64_t j = 0;
    for (; j + lanes <= n; j += lanes) {
        const auto four = hn::Add(sum_of_two(d, r0 + j, r1 + j), sum_of_two(d, r2 + j, r3 + j));
        const auto six = hn::Add(four, sum_of_two(d, r4 + j, r5 + j));
        hn::StoreU(hn::Add(hn::Mul(c, hn::LoadU(d, v + j)), hn::Mul(w, six)), d, out + j);
    }
    for (; j < n; ++j)
        out[j] = centre * v[j] + ring * (((r0[j] + r1[j]) + (r2[j] + r3[j])) + (r4[j] + r5[j]));
}

template <class T>
void predict(T ends, T opposite, const T* e, const Four<T>& v, std::int64_t n, T* out) {
    const auto [v0, v1, v2, v3] = v;
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto a = hn::Set(d, ends);
    const auto b = hn::Set(d, opposite);
    std::int64_t j = 0;
    for (; j + lanes <= n; j += lanes) {
        const auto near = hn::Mul(a, sum_of_two(d, v0 + j, v1 + j));
        const auto far = hn::Mul(b, sum_of_two(d, v2 + j, v3 + j));
        hn::StoreU(hn::Add(hn::LoadU(d, e + j), hn::Add(near, far)), d, out + j);
    }
    for (; j < n; ++j) out[j] = e[j] + (ends * (v0[j] + v1[j]) + opposite * (v2[j] + v3[j]));
}

template <class T>
void from_ends(T ends, const T* e, const T* begin, const T* end, std::int64_t n, T* out) {
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto a = hn::Set(d, ends);
    std::int64_t j = 0;
    for (; j + lanes <= n; j += lanes) {
        const auto near = hn::Mul(a, sum_of_two(d, begin + j, end + j));
        hn::StoreU(hn::Add(hn::LoadU(d, e + j), near), d, out + j);
    }
    for (; j < n; ++j) out[j] = e[j] + ends * (begin[j] + end[j]);
}

#define RELIEF_KERNELS(T, S)                                                            \
    void step_##S(T c, T r, const T* v, const Six<T>& a, std::int64_t n, T* o) {        \
        step(c, r, v, a, n, o);                                                         \
    }                                                                                   \
    void predict_##S(T a, T b, const T* e, const Four<T>& v, std::int64_t n, T* o) {    \
        predict(a, b, e, v, n, o);                                                      \
    }                                                                                   \
    void from_ends_##S(T a, const T* e, const T* v, const T* w, std::int64_t n, T* o) { \
        from_ends(a, e, v, w, n, o);                                                    \
    }
RELIEF_KERNELS(float, f)
RELIEF_KERNELS(double, d)
#undef RELIEF_KERNELS

}  // namespace HWY_NAMESPACE
}  // namespace relief::multires::box
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::multires::box {

#define RELIEF_EXPORT(T, S)                                                                       \
    HWY_EXPORT(step_##S);                                                                         \
    HWY_EXPORT(predict_##S);                                                                      \
    HWY_EXPORT(from_ends_##S);                                                                    \
    template <>                                                                                   \
    void step_row(T c, T r, const T* v, const std::array<const T*, 6>& a, std::int64_t n,         \
                  T* out) {                                                                       \
        if (simd_enabled()) return HWY_DYNAMIC_DISPATCH(step_##S)(c, r, v, a, n, out);            \
        for (std::int64_t j = 0; j < n; ++j)                                                      \
            out[j] = c * v[j] +                                                                   \
                     r * (((a[0][j] + a[1][j]) + (a[2][j] + a[3][j])) + (a[4][j] + a[5][j]));     \
    }                                                                                             \
    template <>                                                                                   \
    void predict_row(T a, T b, const T* e, const std::array<const T*, 4>& v, std::int64_t n,      \
                     T* out) {                                                                    \
        if (simd_enabled()) return HWY_DYNAMIC_DISPATCH(predict_##S)(a, b, e, v, n, out);         \
        for (std::int64_t j = 0; j < n; ++j)                                                      \
            out[j] = e[j] + (a * (v[0][j] + v[1][j]) + b * (v[2][j] + v[3][j]));                  \
    }                                                                                             \
    template <>                                                                                   \
    void predict_row_from_ends(T a, const T* e, const T* begin, const T* end, std::int64_t n,     \
                               T* out) {                                                          \
        if (simd_enabled()) return HWY_DYNAMIC_DISPATCH(from_ends_##S)(a, e, begin, end, n, out); \
        for (std::int64_t j = 0; j < n; ++j) out[j] = e[j] + a * (begin[j] + end[j]);             \
    }
RELIEF_EXPORT(float, f)
RELIEF_EXPORT(double, d)
#undef RELIEF_EXPORT

}  // namespace relief::multires::box
#endif  // HWY_ONCE
