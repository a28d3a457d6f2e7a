#include "multires/row_copy.h"

#include <algorithm>

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "multires/row_copy.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace relief::multires {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class T>
void copy(const T* row, std::int64_t n, T* out) {
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    std::int64_t j = 0;
    for (; j + lanes <= n; j += lanes) hn::StoreU(hn::LoadU(d, row + j), d, out + j);
    for (; j < n; ++j) out[j] = row[j];
}

/// Past the caches from the first cache line of `out` to its last whole one.
template <class T>
void stream(const T* row, std::int64_t n, T* out) {
    const hn::CappedTag<T, 64 / sizeof(T)> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    constexpr std::int64_t line = 64 / sizeof(T);
    const auto misaligned =
        static_cast<std::int64_t>(reinterpret_cast<std::uintptr_t>(out) % 64 / sizeof(T));
    const std::int64_t head = std::min(n, (line - misaligned) % line);
    std::int64_t j = 0;
    for (; j < head; ++j) out[j] = row[j];
    for (; j + line <= n; j += line)
        for (std::int64_t k = j; k < j + line; k += lanes)
            hn::Stream(hn::LoadU(d, row + k), d, out + k);
    for (; j < n; ++j) out[j] = row[j];
}

#define RELIEF_KERNELS(T, S)                            \
    void copy_##S(const T* r, std::int64_t n, T* o) {   \
        copy(r, n, o);                                  \
    }                                                   \
    void stream_##S(const T* r, std::int64_t n, T* o) { \
        stream(r, n, o);                                \
    }
RELIEF_KERNELS(float, f)
RELIEF_KERNELS(double, d)
#undef RELIEF_KERNELS

}  // namespace HWY_NAMESPACE
}  // namespace relief::multires
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::multires {

#define RELIEF_EXPORT(T, S)                                                \
    HWY_EXPORT(copy_##S);                                                  \
    HWY_EXPORT(stream_##S);                                                \
    template <>                                                            \
    void copy_row(const T* row, std::int64_t n, T* out, Traffic traffic) { \
        if (!simd_enabled()) {                                             \
            std::copy_n(row, n, out);                                      \
        } else if (traffic == Traffic::Streamed) {                         \
            HWY_DYNAMIC_DISPATCH(stream_##S)(row, n, out);                 \
        } else {                                                           \
            HWY_DYNAMIC_DISPATCH(copy_##S)(row, n, out);                   \
        }                                                                  \
    }
RELIEF_EXPORT(float, f)
RELIEF_EXPORT(double, d)
#undef RELIEF_EXPORT

void finish_streaming() {
    hwy::FlushStream();
}

}  // namespace relief::multires
#endif  // HWY_ONCE
