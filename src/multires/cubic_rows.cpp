#include "multires/cubic_rows.h"

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "multires/cubic_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef RELIEF_CUBIC_LIFTED
#define RELIEF_CUBIC_LIFTED
namespace relief::multires::cubic {
template <class T>
T lifted(const T* in, const Neighbours<T>& from, std::int64_t j) {
    T sum = from.weight[0] * (from.lower[0][j] + from.upper[0][j]);
    for (int k = 1; k < kTaps; ++k)
        sum = sum + from.weight[k] * (from.lower[k][j] + from.upper[k][j]);
    return in[j] + sum;
}
}  // namespace relief::multires::cubic
#endif

HWY_BEFORE_NAMESPACE();
namespace relief::multires::cubic {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class T>
void lift(T* out, const T* in, const Neighbours<T>& from, std::int64_t first, std::int64_t last) {
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto pair = [&](int k, std::int64_t j) {
        return hn::Add(hn::LoadU(d, from.lower[k] + j), hn::LoadU(d, from.upper[k] + j));
    };
    std::int64_t j = first;
    for (; j + 2 * lanes <= last; j += 2 * lanes) {
        auto weight = hn::Set(d, from.weight[0]);
        auto sum0 = hn::Mul(weight, pair(0, j));
        auto sum1 = hn::Mul(weight, pair(0, j + lanes));
        for (int k = 1; k < kTaps; ++k) {
            weight = hn::Set(d, from.weight[k]);
            sum0 = hn::Add(sum0, hn::Mul(weight, pair(k, j)));
            sum1 = hn::Add(sum1, hn::Mul(weight, pair(k, j + lanes)));
        }
        const auto in0 = hn::LoadU(d, in + j);
        const auto in1 = hn::LoadU(d, in + j + lanes);
        hn::StoreU(hn::Add(in0, sum0), d, out + j);
        hn::StoreU(hn::Add(in1, sum1), d, out + j + lanes);
    }
    for (; j < last; ++j) out[j] = lifted(in, from, j);
}

#define RELIEF_KERNEL(T, S)                                                           \
    void lift_##S(T* out, const T* in, const Neighbours<T>& from, std::int64_t first, \
                  std::int64_t last) {                                                \
        lift(out, in, from, first, last);                                             \
    }
RELIEF_KERNEL(float, f)
RELIEF_KERNEL(double, d)
#undef RELIEF_KERNEL

}  // namespace HWY_NAMESPACE
}  // namespace relief::multires::cubic
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::multires::cubic {

#define RELIEF_EXPORT(T, S)                                                                    \
    HWY_EXPORT(lift_##S);                                                                      \
    template <>                                                                                \
    void lift_row(T* out, const T* in, const Neighbours<T>& from, std::int64_t first,          \
                  std::int64_t last) {                                                         \
        if (simd_enabled()) return HWY_DYNAMIC_DISPATCH(lift_##S)(out, in, from, first, last); \
        for (std::int64_t j = first; j < last; ++j) out[j] = lifted(in, from, j);              \
    }
RELIEF_EXPORT(float, f)
RELIEF_EXPORT(double, d)
#undef RELIEF_EXPORT

}  // namespace relief::multires::cubic
#endif  // HWY_ONCE
