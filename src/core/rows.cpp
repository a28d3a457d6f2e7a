#include "relief/core/rows.h"

#include <atomic>

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace relief {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Four vectors at a time, so that the address of each tap is loaded once for four results.
template <bool kAdd, class T>
void fir(T* HWY_RESTRICT out, std::int64_t n, const RowTap<T>* taps, int count) {
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const int first = kAdd ? 0 : 1;
    std::int64_t k = 0;
    for (; k + 4 * lanes <= n; k += 4 * lanes) {
        const T* lead = kAdd ? out + k : taps[0].row + k;
        auto s0 = hn::LoadU(d, lead);
        auto s1 = hn::LoadU(d, lead + lanes);
        auto s2 = hn::LoadU(d, lead + 2 * lanes);
        auto s3 = hn::LoadU(d, lead + 3 * lanes);
        if (!kAdd) {
            const auto w = hn::Set(d, taps[0].weight);
            s0 = hn::Mul(w, s0);
            s1 = hn::Mul(w, s1);
            s2 = hn::Mul(w, s2);
            s3 = hn::Mul(w, s3);
        }
        for (int t = first; t < count; ++t) {
            const auto w = hn::Set(d, taps[t].weight);
            const T* row = taps[t].row + k;
            s0 = hn::Add(s0, hn::Mul(w, hn::LoadU(d, row)));
            s1 = hn::Add(s1, hn::Mul(w, hn::LoadU(d, row + lanes)));
            s2 = hn::Add(s2, hn::Mul(w, hn::LoadU(d, row + 2 * lanes)));
            s3 = hn::Add(s3, hn::Mul(w, hn::LoadU(d, row + 3 * lanes)));
        }
        hn::StoreU(s0, d, out + k);
        hn::StoreU(s1, d, out + k + lanes);
        hn::StoreU(s2, d, out + k + 2 * lanes);
        hn::StoreU(s3, d, out + k + 3 * lanes);
    }
    for (; k + lanes <= n; k += lanes) {
        auto sum = hn::LoadU(d, kAdd ? out + k : taps[0].row + k);
        if (!kAdd) sum = hn::Mul(hn::Set(d, taps[0].weight), sum);
        for (int t = first; t < count; ++t)
            sum = hn::Add(sum, hn::Mul(hn::Set(d, taps[t].weight), hn::LoadU(d, taps[t].row + k)));
        hn::StoreU(sum, d, out + k);
    }
    for (; k < n; ++k) {
        T sum = kAdd ? out[k] : taps[0].weight * taps[0].row[k];
        for (int t = first; t < count; ++t) sum = sum + taps[t].weight * taps[t].row[k];
        out[k] = sum;
    }
}

template <class T>
void split(const T* HWY_RESTRICT src, std::int64_t pairs, T* HWY_RESTRICT even,
           T* HWY_RESTRICT odd) {
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    std::int64_t k = 0;
    for (; k + lanes <= pairs; k += lanes) {
        hn::Vec<decltype(d)> a;
        hn::Vec<decltype(d)> b;
        hn::LoadInterleaved2(d, src + 2 * k, a, b);
        hn::StoreU(a, d, even + k);
        hn::StoreU(b, d, odd + k);
    }
    for (; k < pairs; ++k) {
        even[k] = src[2 * k];
        odd[k] = src[2 * k + 1];
    }
}

template <class T>
void merge(const T* HWY_RESTRICT even, const T* HWY_RESTRICT odd, std::int64_t pairs,
           T* HWY_RESTRICT dst) {
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    std::int64_t k = 0;
    for (; k + lanes <= pairs; k += lanes)
        hn::StoreInterleaved2(hn::LoadU(d, even + k), hn::LoadU(d, odd + k), d, dst + 2 * k);
    for (; k < pairs; ++k) {
        dst[2 * k] = even[k];
        dst[2 * k + 1] = odd[k];
    }
}

template <class T>
void butterfly(const T* a, const T* b, std::int64_t n, T* sum, T* difference) {
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    std::int64_t k = 0;
    for (; k + lanes <= n; k += lanes) {
        const auto x = hn::LoadU(d, a + k);
        const auto y = hn::LoadU(d, b + k);
        hn::StoreU(hn::Add(x, y), d, sum + k);
        hn::StoreU(hn::Sub(x, y), d, difference + k);
    }
    for (; k < n; ++k) {
        const T x = a[k];
        const T y = b[k];
        sum[k] = x + y;
        difference[k] = x - y;
    }
}

#define RELIEF_ROW_KERNELS(T, S)                                             \
    void fir_##S(T* o, std::int64_t n, const RowTap<T>* t, int c) {          \
        fir<false, T>(o, n, t, c);                                           \
    }                                                                        \
    void fir_add_##S(T* o, std::int64_t n, const RowTap<T>* t, int c) {      \
        fir<true, T>(o, n, t, c);                                            \
    }                                                                        \
    void split_##S(const T* s, std::int64_t n, T* e, T* o) {                 \
        split(s, n, e, o);                                                   \
    }                                                                        \
    void merge_##S(const T* e, const T* o, std::int64_t n, T* d) {           \
        merge(e, o, n, d);                                                   \
    }                                                                        \
    void butterfly_##S(const T* a, const T* b, std::int64_t n, T* s, T* d) { \
        butterfly(a, b, n, s, d);                                            \
    }
RELIEF_ROW_KERNELS(float, f)
RELIEF_ROW_KERNELS(double, d)
#undef RELIEF_ROW_KERNELS

}  // namespace HWY_NAMESPACE
}  // namespace relief
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief {

namespace {

std::atomic<bool> g_simd{true};

template <class T>
void fir_scalar(T* out, std::int64_t n, const RowTap<T>* taps, int count) {
    for (std::int64_t k = 0; k < n; ++k) {
        T sum = taps[0].weight * taps[0].row[k];
        for (int t = 1; t < count; ++t) sum = sum + taps[t].weight * taps[t].row[k];
        out[k] = sum;
    }
}

template <class T>
void fir_add_scalar(T* out, std::int64_t n, const RowTap<T>* taps, int count) {
    for (std::int64_t k = 0; k < n; ++k) {
        T sum = out[k];
        for (int t = 0; t < count; ++t) sum = sum + taps[t].weight * taps[t].row[k];
        out[k] = sum;
    }
}

}  // namespace

void set_simd_enabled(bool enabled) {
    g_simd = enabled;
}
bool simd_enabled() {
    return g_simd;
}

std::string simd_target() {
    if (!simd_enabled()) return "scalar";
    const std::int64_t best = hwy::SupportedTargets();
    return hwy::TargetName(best & -best);
}

#define RELIEF_EXPORT(T, S)                                                                     \
    HWY_EXPORT(fir_##S);                                                                        \
    HWY_EXPORT(fir_add_##S);                                                                    \
    HWY_EXPORT(split_##S);                                                                      \
    HWY_EXPORT(merge_##S);                                                                      \
    HWY_EXPORT(butterfly_##S);                                                                  \
    template <>                                                                                 \
    void row_fir(T* out, std::int64_t n, const RowTap<T>* taps, int count) {                    \
        g_simd ? HWY_DYNAMIC_DISPATCH(fir_##S)(out, n, taps, count)                             \
               : fir_scalar(out, n, taps, count);                                               \
    }                                                                                           \
    template <>                                                                                 \
    void row_fir_add(T* out, std::int64_t n, const RowTap<T>* taps, int count) {                \
        g_simd ? HWY_DYNAMIC_DISPATCH(fir_add_##S)(out, n, taps, count)                         \
               : fir_add_scalar(out, n, taps, count);                                           \
    }                                                                                           \
    template <>                                                                                 \
    void row_split(const T* src, std::int64_t pairs, T* even, T* odd) {                         \
        if (g_simd) return HWY_DYNAMIC_DISPATCH(split_##S)(src, pairs, even, odd);              \
        for (std::int64_t k = 0; k < pairs; ++k) even[k] = src[2 * k], odd[k] = src[2 * k + 1]; \
    }                                                                                           \
    template <>                                                                                 \
    void row_merge(const T* even, const T* odd, std::int64_t pairs, T* dst) {                   \
        if (g_simd) return HWY_DYNAMIC_DISPATCH(merge_##S)(even, odd, pairs, dst);              \
        for (std::int64_t k = 0; k < pairs; ++k) dst[2 * k] = even[k], dst[2 * k + 1] = odd[k]; \
    }                                                                                           \
    template <>                                                                                 \
    void row_butterfly(const T* a, const T* b, std::int64_t n, T* sum, T* difference) {         \
        if (g_simd) return HWY_DYNAMIC_DISPATCH(butterfly_##S)(a, b, n, sum, difference);       \
        for (std::int64_t k = 0; k < n; ++k) {                                                  \
            const T x = a[k];                                                                   \
            const T y = b[k];                                                                   \
            sum[k] = x + y;                                                                     \
            difference[k] = x - y;                                                              \
        }                                                                                       \
    }
RELIEF_EXPORT(float, f)
RELIEF_EXPORT(double, d)
#undef RELIEF_EXPORT

}  // namespace relief
#endif  // HWY_ONCE
