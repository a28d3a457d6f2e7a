#include "codec/sample_rows.h"

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "codec/sample_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef RELIEF_CODEC_SAMPLE_ROWS_ONCE
#define RELIEF_CODEC_SAMPLE_ROWS_ONCE
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace relief::codec {

/// Doubles from here on have no fraction: adding this rounds, ties to even.
inline constexpr double kNoFraction = 4503599627370496.0;
/// Relative, of floats.
inline constexpr double kLatticeRounding = 1.2e-7;
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline void integer_row_scalar(const double* samples, std::int64_t n, const IntegerDomain& domain,
                               std::int32_t* out) {
    const double top = domain.highest;
    for (std::int64_t k = 0; k < n; ++k) {
        double v = samples[k];
        if (!domain.floats)
            v /= domain.unit;
        else if (!std::isnan(v))
            v = ordinal_of_float(static_cast<float>(v));
        v -= domain.origin;
        v = v > 0 ? v : 0;  // NaN too
        v = v < top ? v : top;
        out[k] = static_cast<std::int32_t>(v + kNoFraction - kNoFraction);
    }
}

inline void value_row_scalar(const std::int32_t* v, std::int64_t n, const IntegerDomain& domain,
                             double* out) {
    for (std::int64_t k = 0; k < n; ++k) out[k] = domain.value(v[k]);
}

inline void lattice_row_scalar(const double* samples, std::int64_t n, double unit, double* out) {
    for (std::int64_t k = 0; k < n; ++k) out[k] = unit * std::nearbyint(samples[k] / unit);
}

inline std::int64_t count_off_scalar(const double* stored, const double* samples,
                                     const std::uint8_t* valid, std::int64_t n, double bound) {
    std::int64_t off = 0;
    for (std::int64_t k = 0; k < n; ++k) {
        if (valid && !valid[k]) continue;
        const double most = std::min(kLatticeRounding * std::abs(samples[k]), bound);
        off += !is_within(stored[k], samples[k], bound) ||
               (bound > 0 && std::abs(stored[k] - samples[k]) > most);
    }
    return off;
}

inline RowErrors error_row_scalar(const double* decoded, const double* wanted,
                                  const std::uint8_t* valid, std::int64_t n, double bound,
                                  double* errors) {
    RowErrors row{0, true};
    for (std::int64_t k = 0; k < n; ++k) {
        errors[k] = 0;
        if (valid && !valid[k]) continue;
        errors[k] = std::abs(decoded[k] - wanted[k]);
        row.largest = std::max(row.largest, errors[k]);
        row.within &= is_within(decoded[k], wanted[k], bound);
    }
    return row;
}

/// From sample k0 on.
inline void add_squares_scalar(const double* samples, const std::uint8_t* valid, std::int64_t k0,
                               std::int64_t n, double first, double slope, PartialSums& sums) {
    for (std::int64_t k = k0; k < n; ++k) {
        if (valid && !valid[k]) continue;
        const double difference = samples[k] - (first + static_cast<double>(k) * slope);
        sums[static_cast<std::size_t>(k) % sums.size()] += difference * difference;
    }
}

inline std::int32_t largest_difference_scalar(const std::int32_t* a, const std::int32_t* b,
                                              const std::uint8_t* valid, std::int64_t n) {
    std::int32_t largest = 0;
    for (std::int64_t k = 0; k < n; ++k)
        if (!valid || valid[k]) largest = std::max(largest, std::abs(a[k] - b[k]));
    return largest;
}

inline RowRange range_of_row_scalar(const double* samples, const std::uint8_t* valid,
                                    std::int64_t n) {
    RowRange range{kInfinity, -kInfinity, true};
    for (std::int64_t k = 0; k < n; ++k) {
        if (valid && !valid[k]) continue;
        range.lowest = std::min(range.lowest, samples[k]);
        range.highest = std::max(range.highest, samples[k]);
        range.finite &= std::isfinite(samples[k]);
    }
    return range;
}

}  // namespace relief::codec
#endif

HWY_BEFORE_NAMESPACE();
namespace relief::codec {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::ScalableTag<double>;
using Indices = hn::Rebind<std::int32_t, Doubles>;
using Integers = hn::ScalableTag<std::int32_t>;

template <class D>
std::int64_t lanes_of(D d) {
    return static_cast<std::int64_t>(hn::Lanes(d));
}

/// Lanes that are no holes.
template <class D>
HWY_INLINE hn::Mask<D> valid_lanes(D d, const std::uint8_t* valid) {
    const hn::Rebind<std::int64_t, D> d64;
    const hn::Rebind<std::int32_t, D> d32;
    const hn::Rebind<std::uint8_t, D> d8;
    if (!valid) return hn::FirstN(d, hn::Lanes(d));
    const auto wide = hn::PromoteTo(d64, hn::PromoteTo(d32, hn::LoadU(d8, valid)));
    return hn::RebindMask(d, hn::Ne(wide, hn::Zero(d64)));
}

void integers(const double* samples, std::int64_t n, const IntegerDomain& domain,
              std::int32_t* out) {
    const Doubles d;
    const auto unit = hn::Set(d, domain.unit);
    const auto origin = hn::Set(d, domain.origin);
    const auto top = hn::Set(d, static_cast<double>(domain.highest));
    const auto no_fraction = hn::Set(d, kNoFraction);
    std::int64_t k = 0;
    for (; k + lanes_of(d) <= n; k += lanes_of(d)) {
        const auto v = hn::Sub(hn::Div(hn::LoadU(d, samples + k), unit), origin);
        const auto above = hn::IfThenElseZero(hn::Gt(v, hn::Zero(d)), v);  // NaN becomes 0
        const auto clamped = hn::Min(above, top);
        const auto whole = hn::Sub(hn::Add(clamped, no_fraction), no_fraction);
        hn::StoreU(hn::DemoteTo(Indices(), whole), Indices(), out + k);
    }
    integer_row_scalar(samples + k, n - k, domain, out + k);
}

void values(const std::int32_t* v, std::int64_t n, const IntegerDomain& domain, double* out) {
    const Doubles d;
    const auto unit = hn::Set(d, domain.unit);
    const auto origin = hn::Set(d, domain.origin);
    std::int64_t k = 0;
    for (; k + lanes_of(d) <= n; k += lanes_of(d)) {
        const auto integer = hn::PromoteTo(d, hn::LoadU(Indices(), v + k));
        hn::StoreU(hn::Mul(unit, hn::Add(origin, integer)), d, out + k);
    }
    value_row_scalar(v + k, n - k, domain, out + k);
}

void on_lattice(const double* samples, std::int64_t n, double unit, double* out) {
    const Doubles d;
    const auto units = hn::Set(d, unit);
    std::int64_t k = 0;
    for (; k + lanes_of(d) <= n; k += lanes_of(d)) {
        const auto nearest = hn::Round(hn::Div(hn::LoadU(d, samples + k), units));
        hn::StoreU(hn::Mul(units, nearest), d, out + k);
    }
    lattice_row_scalar(samples + k, n - k, unit, out + k);
}

/// Lanes that keep the bound; `error` is the distance of a and b.
HWY_INLINE hn::Mask<Doubles> within(hn::Vec<Doubles> a, hn::Vec<Doubles> b, hn::Vec<Doubles> error,
                                    double bound) {
    const Doubles d;
    const hn::Rebind<std::int64_t, Doubles> d64;
    if (bound > 0) return hn::Le(error, hn::Set(d, bound));
    return hn::RebindMask(d, hn::Eq(hn::BitCast(d64, a), hn::BitCast(d64, b)));
}

std::int64_t off(const double* stored, const double* samples, const std::uint8_t* valid,
                 std::int64_t n, double bound) {
    const Doubles d;
    std::int64_t count = 0;
    std::int64_t k = 0;
    for (; k + lanes_of(d) <= n; k += lanes_of(d)) {
        const auto a = hn::LoadU(d, stored + k);
        const auto b = hn::LoadU(d, samples + k);
        const auto error = hn::Abs(hn::Sub(a, b));
        auto on = within(a, b, error, bound);
        if (bound > 0)
            on = hn::And(on, hn::Le(error, hn::Mul(hn::Set(d, kLatticeRounding), hn::Abs(b))));
        const auto here = valid_lanes(d, valid ? valid + k : nullptr);
        count += static_cast<std::int64_t>(hn::CountTrue(d, hn::AndNot(on, here)));
    }
    return count +
           count_off_scalar(stored + k, samples + k, valid ? valid + k : nullptr, n - k, bound);
}

RowErrors errors(const double* decoded, const double* wanted, const std::uint8_t* valid,
                 std::int64_t n, double bound, double* out) {
    const Doubles d;
    auto over = hn::FirstN(d, 0);
    auto largest = hn::Zero(d);
    std::int64_t k = 0;
    for (; k + lanes_of(d) <= n; k += lanes_of(d)) {
        const auto a = hn::LoadU(d, decoded + k);
        const auto b = hn::LoadU(d, wanted + k);
        const auto here = valid_lanes(d, valid ? valid + k : nullptr);
        const auto error = hn::IfThenElseZero(here, hn::Abs(hn::Sub(a, b)));
        over = hn::Or(over, hn::AndNot(within(a, b, error, bound), here));
        largest = hn::Max(largest, error);
        hn::StoreU(error, d, out + k);
    }
    const RowErrors rest = error_row_scalar(decoded + k, wanted + k, valid ? valid + k : nullptr,
                                            n - k, bound, out + k);
    return {std::max(rest.largest, hn::GetLane(hn::MaxOfLanes(d, largest))),
            rest.within && hn::AllFalse(d, over)};
}

void squares(const double* samples, const std::uint8_t* valid, std::int64_t n, double first,
             double slope, PartialSums& sums) {
    const hn::CappedTag<double, PartialSums().size()> d;
    const auto size = static_cast<std::int64_t>(sums.size());
    const auto slopes = hn::Set(d, slope);
    const std::int64_t whole = n / size * size;
    for (std::int64_t i = 0; i < size; i += lanes_of(d)) {
        auto sum = hn::LoadU(d, sums.data() + i);
        for (std::int64_t k = i; k < whole; k += size) {
            const auto line =
                hn::Add(hn::Set(d, first), hn::Mul(hn::Iota(d, static_cast<double>(k)), slopes));
            const auto here = valid_lanes(d, valid ? valid + k : nullptr);
            const auto difference =
                hn::IfThenElseZero(here, hn::Sub(hn::LoadU(d, samples + k), line));
            sum = hn::Add(sum, hn::Mul(difference, difference));
        }
        hn::StoreU(sum, d, sums.data() + i);
    }
    add_squares_scalar(samples, valid, whole, n, first, slope, sums);
}

std::int32_t difference(const std::int32_t* a, const std::int32_t* b, const std::uint8_t* valid,
                        std::int64_t n) {
    const Integers d;
    const hn::Rebind<std::uint8_t, Integers> d8;
    auto largest = hn::Zero(d);
    std::int64_t k = 0;
    for (; k + lanes_of(d) <= n; k += lanes_of(d)) {
        const auto size = hn::Abs(hn::Sub(hn::LoadU(d, a + k), hn::LoadU(d, b + k)));
        if (!valid) {
            largest = hn::Max(largest, size);
            continue;
        }
        const auto here = hn::Ne(hn::PromoteTo(d, hn::LoadU(d8, valid + k)), hn::Zero(d));
        largest = hn::Max(largest, hn::IfThenElseZero(here, size));
    }
    return std::max(hn::GetLane(hn::MaxOfLanes(d, largest)),
                    largest_difference_scalar(a + k, b + k, valid ? valid + k : nullptr, n - k));
}

RowRange range(const double* samples, const std::uint8_t* valid, std::int64_t n) {
    const Doubles d;
    auto lowest = hn::Set(d, kInfinity);
    auto highest = hn::Set(d, -kInfinity);
    auto finite = hn::FirstN(d, hn::Lanes(d));
    std::int64_t k = 0;
    for (; k + lanes_of(d) <= n; k += lanes_of(d)) {
        const auto v = hn::LoadU(d, samples + k);
        const auto here = valid_lanes(d, valid ? valid + k : nullptr);
        lowest = hn::Min(lowest, hn::IfThenElse(here, v, lowest));
        highest = hn::Max(highest, hn::IfThenElse(here, v, highest));
        finite = hn::And(finite, hn::Or(hn::Not(here), hn::IsFinite(v)));
    }
    const RowRange rest = range_of_row_scalar(samples + k, valid ? valid + k : nullptr, n - k);
    return {std::min(rest.lowest, hn::GetLane(hn::MinOfLanes(d, lowest))),
            std::max(rest.highest, hn::GetLane(hn::MaxOfLanes(d, highest))),
            rest.finite && hn::AllTrue(d, finite)};
}

}  // namespace HWY_NAMESPACE
}  // namespace relief::codec
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::codec {

namespace {
HWY_EXPORT(integers);
HWY_EXPORT(values);
HWY_EXPORT(on_lattice);
HWY_EXPORT(off);
HWY_EXPORT(errors);
HWY_EXPORT(squares);
HWY_EXPORT(difference);
HWY_EXPORT(range);
}  // namespace

void integer_row(const double* samples, std::int64_t n, const IntegerDomain& domain,
                 std::int32_t* out) {
    if (!simd_enabled() || domain.floats) return integer_row_scalar(samples, n, domain, out);
    HWY_DYNAMIC_DISPATCH(integers)(samples, n, domain, out);
}

void value_row(const std::int32_t* v, std::int64_t n, const IntegerDomain& domain, double* out) {
    if (!simd_enabled() || domain.floats) return value_row_scalar(v, n, domain, out);
    HWY_DYNAMIC_DISPATCH(values)(v, n, domain, out);
}

void lattice_row(const double* samples, std::int64_t n, double unit, double* out) {
    if (!simd_enabled()) return lattice_row_scalar(samples, n, unit, out);
    HWY_DYNAMIC_DISPATCH(on_lattice)(samples, n, unit, out);
}

std::int64_t count_off(const double* stored, const double* samples, const std::uint8_t* valid,
                       std::int64_t n, double bound) {
    if (!simd_enabled()) return count_off_scalar(stored, samples, valid, n, bound);
    return HWY_DYNAMIC_DISPATCH(off)(stored, samples, valid, n, bound);
}

RowErrors error_row(const double* decoded, const double* wanted, const std::uint8_t* valid,
                    std::int64_t n, double bound, double* out) {
    if (!simd_enabled()) return error_row_scalar(decoded, wanted, valid, n, bound, out);
    return HWY_DYNAMIC_DISPATCH(errors)(decoded, wanted, valid, n, bound, out);
}

void add_squares(const double* samples, const std::uint8_t* valid, std::int64_t n, double first,
                 double slope, PartialSums& sums) {
    if (!simd_enabled()) return add_squares_scalar(samples, valid, 0, n, first, slope, sums);
    HWY_DYNAMIC_DISPATCH(squares)(samples, valid, n, first, slope, sums);
}

std::int32_t largest_difference(const std::int32_t* a, const std::int32_t* b,
                                const std::uint8_t* valid, std::int64_t n) {
    if (!simd_enabled()) return largest_difference_scalar(a, b, valid, n);
    return HWY_DYNAMIC_DISPATCH(difference)(a, b, valid, n);
}

RowRange range_of_row(const double* samples, const std::uint8_t* valid, std::int64_t n) {
    if (!simd_enabled()) return range_of_row_scalar(samples, valid, n);
    return HWY_DYNAMIC_DISPATCH(range)(samples, valid, n);
}

}  // namespace relief::codec
#endif  // HWY_ONCE
