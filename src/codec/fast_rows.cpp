#include "codec/fast_rows.h"

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "codec/fast_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef RELIEF_CODEC_FAST_ROWS_ONCE
#define RELIEF_CODEC_FAST_ROWS_ONCE
#include <algorithm>
#include <bit>
#include <cstdlib>
#include <type_traits>

namespace relief::codec::fast {

/// The size of quotients that is expected, kTextureWeight texture / step + kQuotientWeight times
/// the sum of quotients around, in classes of half an octave: 0 below 1.5, then from 1.5, 2, 3, 4,
/// 6, 8 .., which the exponent and the first bit of the mantissa of a float tell.
inline constexpr float kTextureWeight = 0.88F;
inline constexpr float kQuotientWeight = 1.0F;
inline constexpr int kHalfOctaveShift = 22;
inline constexpr int kClassZeroBits = 127 << 1;  ///< of 1, the last half octave of class 0
inline constexpr std::int16_t kQuotientLimit = 40;
inline constexpr std::int32_t kTextureLimit = 1 << 30;
inline constexpr std::int16_t kKeptLimit = 30000;

/// The same bits of |q| - 1 = 4, the first magnitude that shares its token, less that token.
inline constexpr std::int32_t kFirstSharedBits = (129 << 1) - kOwnTokens;

/// The low bits of large numbers, which rounding to float could carry into the exponent.
inline std::int32_t without_tail(std::int32_t v) {
    return v & ~(v >> 8);
}

inline void split_values_scalar(const std::int32_t* samples, std::int64_t n, const RowRule& rule,
                                std::int32_t* even) {
    const std::int32_t least = rule.floor + rule.origin;
    const std::int32_t most = rule.ceiling + rule.origin;
    for (std::int64_t k = 0; k < n; ++k)
        even[k] = std::clamp(samples[2 * k], least, most) - rule.origin;
}

inline void split_quotients_scalar(const std::int16_t* samples, std::int64_t n,
                                   std::int16_t* even) {
    for (std::int64_t k = 0; k < n; ++k) even[k] = samples[2 * k];
}

inline void merge_values_scalar(const std::int32_t* even, const std::int32_t* odd, std::int64_t n,
                                const RowRule& rule, std::int32_t* samples) {
    for (std::int64_t k = 0; k < n; ++k) {
        samples[2 * k] = even[k] + rule.origin;
        samples[2 * k + 1] = odd[k] + rule.origin;
    }
}

inline void merge_quotients_scalar(const std::int16_t* even, const std::int16_t* odd,
                                   std::int64_t n, std::int16_t* samples) {
    for (std::int64_t k = 0; k < n; ++k) {
        samples[2 * k] = even[k];
        samples[2 * k + 1] = odd[k];
    }
}

template <bool kClassify>
void predict_scalar(const Neighbours& at, std::int64_t n, const RowRule& rule,
                    std::int32_t* predictions, std::uint8_t* classes) {
    const float texture_weight = kTextureWeight / static_cast<float>(rule.step);
    for (std::int64_t k = 0; k < n; ++k) {
        const std::int64_t a = at.near[0][k];
        const std::int64_t b = at.near[1][k];
        const std::int64_t c = at.near[2][k];
        const std::int64_t d = at.near[3][k];
        const std::int64_t near = a + b + c + d;
        std::int64_t far = 0;
        for (const std::int32_t* row : at.far) far += row[k];
        predictions[k] = static_cast<std::int32_t>(
            std::clamp<std::int64_t>((10 * near - far + 16) >> 5, rule.lowest, rule.highest));
        if constexpr (kClassify) {
            const std::int64_t texture = std::abs(a + b - c - d) + (std::abs(2 * near - far) >> 2) +
                                         ((std::abs(a - b) + std::abs(c - d)) >> 2);
            const auto magnitude = [k](const std::int16_t* q) {
                return std::min(std::abs(int{q[k]}), int{kQuotientLimit});
            };
            int quotients = 0;
            for (const std::int16_t* q : at.near_quotients) quotients += magnitude(q);
            for (const std::int16_t* q : at.earlier_quotients) quotients += 2 * magnitude(q);
            const float size = static_cast<float>(std::min<std::int64_t>(texture, kTextureLimit)) *
                                   texture_weight +
                               static_cast<float>(quotients) * kQuotientWeight;
            const std::int32_t bits = std::bit_cast<std::int32_t>(size) >> kHalfOctaveShift;
            classes[k] =
                static_cast<std::uint8_t>(std::clamp(bits - kClassZeroBits, 0, kClasses - 1));
        }
    }
}

inline std::uint8_t token_of(std::int32_t magnitude) {
    if (magnitude < kOwnTokens) return static_cast<std::uint8_t>(magnitude);
    const auto rest = static_cast<float>(without_tail(magnitude - 1));
    return static_cast<std::uint8_t>(std::min(
        (std::bit_cast<std::int32_t>(rest) >> kHalfOctaveShift) - kFirstSharedBits, kTokens - 1));
}

inline void quantise_scalar(const std::int32_t* sources, const std::int32_t* predictions,
                            const std::uint8_t* classes, std::int64_t n, const RowRule& rule,
                            std::int32_t* quotients, std::uint8_t* tokens) {
    for (std::int64_t k = 0; k < n; ++k) {
        quotients[k] = 0;
        tokens[k] = 0;
        if (classes[k] == kSilent) continue;
        const std::int32_t rest = sources[k] - predictions[k];
        const auto magnitude = static_cast<std::int32_t>(
            (std::int64_t{std::abs(rest)} + (rule.step - 1) / 2) / rule.step);
        quotients[k] = rest < 0 ? -magnitude : magnitude;
        tokens[k] = token_of(magnitude);
    }
}

inline void reconstruct_scalar(const std::int32_t* predictions, const std::int32_t* quotients,
                               std::int64_t n, const RowRule& rule, std::int32_t* values,
                               std::int16_t* kept) {
    for (std::int64_t k = 0; k < n; ++k) {
        const auto value =
            static_cast<std::uint32_t>(predictions[k]) +
            static_cast<std::uint32_t>(quotients[k]) * static_cast<std::uint32_t>(rule.step);
        values[k] = std::clamp(static_cast<std::int32_t>(value), rule.floor, rule.ceiling);
        kept[k] = static_cast<std::int16_t>(
            std::clamp<std::int32_t>(quotients[k], -kKeptLimit, kKeptLimit));
    }
}

}  // namespace relief::codec::fast
#endif

HWY_BEFORE_NAMESPACE();
namespace relief::codec::fast {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class T>
std::int64_t lanes_of() {
    return static_cast<std::int64_t>(hn::Lanes(hn::ScalableTag<T>()));
}

/// Calls block(k) for blocks of `lanes` elements that cover 0 .. n - 1. The last may overlap the
/// one before, so kernels must not read what they write. Requires: n >= lanes.
template <class Block>
HWY_INLINE void for_blocks(std::int64_t n, std::int64_t lanes, Block block) {
    std::int64_t k = 0;
    for (; k + lanes <= n; k += lanes) block(k);
    if (k < n) block(n - lanes);
}

/// Loads of pairs stop before the last element, behind which a row may end.
void split_values(const std::int32_t* samples, std::int64_t n, const RowRule& rule,
                  std::int32_t* even) {
    const hn::ScalableTag<std::int32_t> d;
    const std::int64_t lanes = lanes_of<std::int32_t>();
    const auto origin = hn::Set(d, rule.origin);
    const auto least = hn::Set(d, rule.floor + rule.origin);
    const auto most = hn::Set(d, rule.ceiling + rule.origin);
    std::int64_t k = 0;
    for (; k + lanes < n; k += lanes) {
        hn::Vec<decltype(d)> v;
        hn::Vec<decltype(d)> unused;
        hn::LoadInterleaved2(d, samples + 2 * k, v, unused);
        hn::StoreU(hn::Sub(hn::Min(hn::Max(v, least), most), origin), d, even + k);
    }
    split_values_scalar(samples + 2 * k, n - k, rule, even + k);
}

void split_quotients(const std::int16_t* samples, std::int64_t n, std::int16_t* even) {
    const hn::ScalableTag<std::int16_t> d;
    const std::int64_t lanes = lanes_of<std::int16_t>();
    std::int64_t k = 0;
    for (; k + lanes < n; k += lanes) {
        hn::Vec<decltype(d)> v;
        hn::Vec<decltype(d)> unused;
        hn::LoadInterleaved2(d, samples + 2 * k, v, unused);
        hn::StoreU(v, d, even + k);
    }
    split_quotients_scalar(samples + 2 * k, n - k, even + k);
}

void merge_values(const std::int32_t* even, const std::int32_t* odd, std::int64_t n,
                  const RowRule& rule, std::int32_t* samples) {
    const hn::ScalableTag<std::int32_t> d;
    const std::int64_t lanes = lanes_of<std::int32_t>();
    if (n < lanes) return merge_values_scalar(even, odd, n, rule, samples);
    const auto origin = hn::Set(d, rule.origin);
    for_blocks(n, lanes, [&](std::int64_t k) HWY_ATTR {
        hn::StoreInterleaved2(hn::Add(hn::LoadU(d, even + k), origin),
                              hn::Add(hn::LoadU(d, odd + k), origin), d, samples + 2 * k);
    });
}

void merge_quotients(const std::int16_t* even, const std::int16_t* odd, std::int64_t n,
                     std::int16_t* samples) {
    const hn::ScalableTag<std::int16_t> d;
    const std::int64_t lanes = lanes_of<std::int16_t>();
    if (n < lanes) return merge_quotients_scalar(even, odd, n, samples);
    for_blocks(n, lanes, [&](std::int64_t k) HWY_ATTR {
        hn::StoreInterleaved2(hn::LoadU(d, even + k), hn::LoadU(d, odd + k), d, samples + 2 * k);
    });
}

/// Sums in T: int32, or double, which holds the same integers of the wide rows exactly.
template <class T>
HWY_INLINE hn::Vec<hn::ScalableTag<T>> load(const std::int32_t* at) {
    const hn::ScalableTag<T> d;
    const hn::Rebind<std::int32_t, decltype(d)> d32;
    if constexpr (std::is_same_v<T, std::int32_t>) {
        return hn::LoadU(d32, at);
    } else {
        return hn::PromoteTo(d, hn::LoadU(d32, at));
    }
}

/// floor(v / 2^kBits).
template <int kBits, class T, class V>
HWY_INLINE V shifted(V v) {
    if constexpr (std::is_same_v<T, std::int32_t>) {
        return hn::ShiftRight<kBits>(v);
    } else {
        return hn::Floor(hn::Mul(v, hn::Set(hn::ScalableTag<T>(), 1.0 / (1 << kBits))));
    }
}

template <class T, class V>
HWY_INLINE hn::Vec<hn::Rebind<std::int32_t, hn::ScalableTag<T>>> narrowed(V v) {
    if constexpr (std::is_same_v<T, std::int32_t>) {
        return v;
    } else {
        return hn::DemoteTo(hn::Rebind<std::int32_t, hn::ScalableTag<T>>(), v);
    }
}

template <class D16>
HWY_INLINE hn::Vec<D16> magnitudes(D16 d, const std::int16_t* quotients) {
    return hn::Min(hn::Abs(hn::LoadU(d, quotients)), hn::Set(d, kQuotientLimit));
}

template <class D16>
HWY_INLINE hn::Vec<D16> sum_of_magnitudes(D16 d, const Neighbours& at, std::int64_t k) {
    const auto earlier = hn::Add(magnitudes(d, at.earlier_quotients[0] + k),
                                 magnitudes(d, at.earlier_quotients[1] + k));
    auto sum = hn::Add(earlier, earlier);
    for (const std::int16_t* quotients : at.near_quotients)
        sum = hn::Add(sum, magnitudes(d, quotients + k));
    return sum;
}

template <class D32>
HWY_INLINE void store_classes(D32 d32, hn::Vec<D32> texture, hn::Vec<D32> quotients,
                              float texture_weight, std::uint8_t* classes) {
    const hn::Rebind<float, D32> df;
    const hn::Rebind<std::uint8_t, D32> d8;
    const auto size = hn::Add(hn::Mul(hn::ConvertTo(df, texture), hn::Set(df, texture_weight)),
                              hn::Mul(hn::ConvertTo(df, quotients), hn::Set(df, kQuotientWeight)));
    const auto bits = hn::ShiftRight<kHalfOctaveShift>(hn::BitCast(d32, size));
    const auto unclamped = hn::Sub(bits, hn::Set(d32, kClassZeroBits));
    const auto clamped = hn::Min(hn::Max(unclamped, hn::Zero(d32)), hn::Set(d32, kClasses - 1));
    hn::StoreU(hn::DemoteTo(d8, clamped), d8, classes);
}

template <class T, bool kClassify>
void predict(const Neighbours& at, std::int64_t n, const RowRule& rule, std::int32_t* predictions,
             std::uint8_t* classes) {
    const hn::ScalableTag<T> d;
    const hn::Rebind<std::int32_t, decltype(d)> d32;
    const hn::Rebind<std::int16_t, decltype(d)> d16;
    const std::int64_t lanes = lanes_of<T>();
    if (n < lanes) return predict_scalar<kClassify>(at, n, rule, predictions, classes);
    const auto lowest = hn::Set(d, static_cast<T>(rule.lowest));
    const auto highest = hn::Set(d, static_cast<T>(rule.highest));
    const float texture_weight = kTextureWeight / static_cast<float>(rule.step);
    for_blocks(n, lanes, [&](std::int64_t k) HWY_ATTR {
        const auto p = load<T>(at.near[0] + k);
        const auto q = load<T>(at.near[1] + k);
        const auto r = load<T>(at.near[2] + k);
        const auto s = load<T>(at.near[3] + k);
        const auto pq = hn::Add(p, q);
        const auto rs = hn::Add(r, s);
        const auto near = hn::Add(pq, rs);
        auto far = load<T>(at.far[0] + k);
        for (std::size_t f = 1; f < 8; ++f) far = hn::Add(far, load<T>(at.far[f] + k));
        const auto twice = hn::Add(near, near);
        const auto four = hn::Add(twice, twice);
        const auto ten = hn::Add(hn::Add(four, four), twice);
        const auto sum = hn::Add(hn::Sub(ten, far), hn::Set(d, static_cast<T>(16)));
        const auto prediction = hn::Min(hn::Max(shifted<5, T>(sum), lowest), highest);
        hn::StoreU(narrowed<T>(prediction), d32, predictions + k);
        if constexpr (kClassify) {
            const auto slopes = hn::Add(hn::Abs(hn::Sub(p, q)), hn::Abs(hn::Sub(r, s)));
            const auto texture = hn::Add(
                hn::Add(hn::Abs(hn::Sub(pq, rs)), shifted<2, T>(hn::Abs(hn::Sub(twice, far)))),
                shifted<2, T>(slopes));
            const auto limited = hn::Min(texture, hn::Set(d, static_cast<T>(kTextureLimit)));
            store_classes(d32, narrowed<T>(limited),
                          hn::PromoteTo(d32, sum_of_magnitudes(d16, at, k)), texture_weight,
                          classes + k);
        }
    });
}

void predict_narrow(const Neighbours& at, std::int64_t n, const RowRule& rule,
                    std::int32_t* predictions, std::uint8_t* classes) {
    if (classes) {
        predict<std::int32_t, true>(at, n, rule, predictions, classes);
    } else {
        predict<std::int32_t, false>(at, n, rule, predictions, classes);
    }
}

void predict_wide(const Neighbours& at, std::int64_t n, const RowRule& rule,
                  std::int32_t* predictions, std::uint8_t* classes) {
    if (classes) {
        predict<double, true>(at, n, rule, predictions, classes);
    } else {
        predict<double, false>(at, n, rule, predictions, classes);
    }
}

template <class D32>
HWY_INLINE hn::Vec<D32> tokens_of(D32 d, hn::Vec<D32> magnitudes) {
    const hn::Rebind<float, D32> df;
    const auto rest = hn::Sub(magnitudes, hn::Set(d, 1));
    const auto exact = hn::AndNot(hn::ShiftRight<8>(rest), rest);
    const auto bits = hn::ShiftRight<kHalfOctaveShift>(hn::BitCast(d, hn::ConvertTo(df, exact)));
    const auto shared =
        hn::Min(hn::Sub(bits, hn::Set(d, kFirstSharedBits)), hn::Set(d, kTokens - 1));
    return hn::IfThenElse(hn::Lt(magnitudes, hn::Set(d, kOwnTokens)), magnitudes, shared);
}

/// The quotient in double: (|rest| + step / 2) / step is at least 1 / (2 step) away from integers,
/// far more than rounding moves it.
void quantise(const std::int32_t* sources, const std::int32_t* predictions,
              const std::uint8_t* classes, std::int64_t n, const RowRule& rule,
              std::int32_t* quotients, std::uint8_t* tokens) {
    const hn::ScalableTag<double> d;
    const hn::Rebind<std::int32_t, decltype(d)> d32;
    const hn::Rebind<std::uint8_t, decltype(d)> d8;
    const std::int64_t lanes = lanes_of<double>();
    if (n < lanes)
        return quantise_scalar(sources, predictions, classes, n, rule, quotients, tokens);
    const auto half = hn::Set(d, 0.5 * rule.step);
    const auto inverse = hn::Set(d, 1.0 / rule.step);
    for_blocks(n, lanes, [&](std::int64_t k) HWY_ATTR {
        const auto rest = hn::Sub(hn::LoadU(d32, sources + k), hn::LoadU(d32, predictions + k));
        const auto size = hn::PromoteTo(d, hn::Abs(rest));
        const auto quotient = hn::DemoteTo(d32, hn::Mul(hn::Add(size, half), inverse));
        const auto silent = hn::Eq(hn::PromoteTo(d32, hn::LoadU(d8, classes + k)),
                                   hn::Set(d32, std::int32_t{kSilent}));
        const auto magnitude = hn::IfThenZeroElse(silent, quotient);
        const auto negative = hn::Lt(rest, hn::Zero(d32));
        hn::StoreU(hn::IfThenElse(negative, hn::Neg(magnitude), magnitude), d32, quotients + k);
        hn::StoreU(hn::DemoteTo(d8, tokens_of(d32, magnitude)), d8, tokens + k);
    });
}

void reconstruct(const std::int32_t* predictions, const std::int32_t* quotients, std::int64_t n,
                 const RowRule& rule, std::int32_t* values, std::int16_t* kept) {
    const hn::ScalableTag<std::int32_t> d;
    const hn::Rebind<std::int16_t, decltype(d)> d16;
    const std::int64_t lanes = lanes_of<std::int32_t>();
    if (n < lanes) return reconstruct_scalar(predictions, quotients, n, rule, values, kept);
    const auto step = hn::Set(d, rule.step);
    const auto least = hn::Set(d, rule.floor);
    const auto most = hn::Set(d, rule.ceiling);
    const auto limit = hn::Set(d16, kKeptLimit);
    for_blocks(n, lanes, [&](std::int64_t k) HWY_ATTR {
        const auto q = hn::LoadU(d, quotients + k);
        const auto value = hn::Add(hn::LoadU(d, predictions + k), hn::Mul(q, step));
        hn::StoreU(hn::Min(hn::Max(value, least), most), d, values + k);
        hn::StoreU(hn::Min(hn::Max(hn::DemoteTo(d16, q), hn::Neg(limit)), limit), d16, kept + k);
    });
}

}  // namespace HWY_NAMESPACE
}  // namespace relief::codec::fast
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::codec::fast {

HWY_EXPORT(split_values);
HWY_EXPORT(split_quotients);
HWY_EXPORT(merge_values);
HWY_EXPORT(merge_quotients);
HWY_EXPORT(predict_narrow);
HWY_EXPORT(predict_wide);
HWY_EXPORT(quantise);
HWY_EXPORT(reconstruct);

/// Below this span, ten times four values and their eight far neighbours add up in 32 bits.
constexpr std::int64_t kNarrowSpan = std::int64_t{1} << 24;

RowRule::RowRule(std::int32_t level_lowest, std::int32_t level_highest, std::int32_t level_step)
    : step(level_step) {
    const std::int64_t span = std::int64_t{level_highest} - level_lowest;
    wide = span > kNarrowSpan;
    origin = wide ? 0 : level_lowest;
    lowest = level_lowest - origin;
    highest = level_highest - origin;
    floor = static_cast<std::int32_t>(lowest - span);
    ceiling = static_cast<std::int32_t>(highest + span);
}

void split_values(const std::int32_t* samples, std::int64_t n, const RowRule& rule,
                  std::int32_t* even) {
    if (!simd_enabled()) return split_values_scalar(samples, n, rule, even);
    HWY_DYNAMIC_DISPATCH(split_values)(samples, n, rule, even);
}

void split_quotients(const std::int16_t* samples, std::int64_t n, std::int16_t* even) {
    if (!simd_enabled()) return split_quotients_scalar(samples, n, even);
    HWY_DYNAMIC_DISPATCH(split_quotients)(samples, n, even);
}

void merge_values(const std::int32_t* even, const std::int32_t* odd, std::int64_t n,
                  const RowRule& rule, std::int32_t* samples) {
    if (!simd_enabled()) return merge_values_scalar(even, odd, n, rule, samples);
    HWY_DYNAMIC_DISPATCH(merge_values)(even, odd, n, rule, samples);
}

void merge_quotients(const std::int16_t* even, const std::int16_t* odd, std::int64_t n,
                     std::int16_t* samples) {
    if (!simd_enabled()) return merge_quotients_scalar(even, odd, n, samples);
    HWY_DYNAMIC_DISPATCH(merge_quotients)(even, odd, n, samples);
}

void predict_row(const Neighbours& neighbours, std::int64_t n, const RowRule& rule,
                 std::int32_t* predictions) {
    if (!simd_enabled()) return predict_scalar<false>(neighbours, n, rule, predictions, nullptr);
    rule.wide ? HWY_DYNAMIC_DISPATCH(predict_wide)(neighbours, n, rule, predictions, nullptr)
              : HWY_DYNAMIC_DISPATCH(predict_narrow)(neighbours, n, rule, predictions, nullptr);
}

void predict_row(const Neighbours& neighbours, std::int64_t n, const RowRule& rule,
                 std::int32_t* predictions, std::uint8_t* classes) {
    if (!simd_enabled()) return predict_scalar<true>(neighbours, n, rule, predictions, classes);
    rule.wide ? HWY_DYNAMIC_DISPATCH(predict_wide)(neighbours, n, rule, predictions, classes)
              : HWY_DYNAMIC_DISPATCH(predict_narrow)(neighbours, n, rule, predictions, classes);
}

void quantise_row(const std::int32_t* sources, const std::int32_t* predictions,
                  const std::uint8_t* classes, std::int64_t n, const RowRule& rule,
                  std::int32_t* quotients, std::uint8_t* tokens) {
    if (!simd_enabled())
        return quantise_scalar(sources, predictions, classes, n, rule, quotients, tokens);
    HWY_DYNAMIC_DISPATCH(quantise)(sources, predictions, classes, n, rule, quotients, tokens);
}

void reconstruct_row(const std::int32_t* predictions, const std::int32_t* quotients, std::int64_t n,
                     const RowRule& rule, std::int32_t* values, std::int16_t* kept) {
    if (!simd_enabled()) return reconstruct_scalar(predictions, quotients, n, rule, values, kept);
    HWY_DYNAMIC_DISPATCH(reconstruct)(predictions, quotients, n, rule, values, kept);
}

}  // namespace relief::codec::fast
#endif  // HWY_ONCE
