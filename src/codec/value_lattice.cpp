#include "codec/value_lattice.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace relief::codec {

namespace {

constexpr std::array<double, kMostDigits10 + 1> kPowers = {
    1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

/// Decimals whose integers are larger are coded as doubles: rounding of their products would show.
constexpr double kLargestDecimal = 0x1p50;
constexpr double kLargestInteger = 0x1p62;
constexpr double kLargestFloat = 0x1.fffffep127;

constexpr std::int64_t kSign64 = INT64_MIN;
constexpr std::int32_t kSign32 = INT32_MIN;

std::int32_t float_ordinal_of(float value) {
    const auto bits = std::bit_cast<std::int32_t>(value);
    return bits < 0 ? ~(bits ^ kSign32) : bits;
}

double float_at(std::int64_t ordinal) {
    const auto place = static_cast<std::int32_t>(ordinal);
    return std::bit_cast<float>(place < 0 ? ~place ^ kSign32 : place);
}

std::int64_t rounded(double x) {
    if (std::isnan(x)) return 0;
    return static_cast<std::int64_t>(std::rint(std::clamp(x, -kLargestInteger, kLargestInteger)));
}

bool is_decimal(double value, double power) {
    const double integer = std::rint(value * power);
    return std::abs(integer) <= kLargestDecimal &&
           ordinal_of(integer / power + 0.0) == ordinal_of(value);
}

bool is_float(double value) {
    return std::abs(value) <= kLargestFloat &&
           ordinal_of(static_cast<double>(static_cast<float>(value))) == ordinal_of(value);
}

}  // namespace

double power_of_ten(int digits) {
    return kPowers[static_cast<std::size_t>(digits)];
}

std::optional<int> decimal_digits(std::span<const double> values) {
    int digits = 0;
    for (const double value : values)
        while (!is_decimal(value, power_of_ten(digits)))
            if (++digits > kMostDigits10) return std::nullopt;
    const auto fits = [power = power_of_ten(digits)](double v) { return is_decimal(v, power); };
    if (!std::all_of(values.begin(), values.end(), fits)) return std::nullopt;
    return digits;
}

std::int64_t ordinal_of(double value) {
    const auto bits = std::bit_cast<std::int64_t>(value);
    return bits < 0 ? ~(bits ^ kSign64) : bits;
}

double double_at(std::int64_t ordinal) {
    return std::bit_cast<double>(ordinal < 0 ? ~ordinal ^ kSign64 : ordinal);
}

ValueLattice ValueLattice::exact(std::span<const double> values) {
    if (const auto digits = decimal_digits(values))
        return {.kind = Kind::Decimal, .digits = *digits};
    const bool floats = std::all_of(values.begin(), values.end(), is_float);
    return {.kind = floats ? Kind::Float32 : Kind::Float64};
}

ValueLattice ValueLattice::within(double tolerance) const {
    if (kind != Kind::Decimal) return {.kind = Kind::Step, .step = 2 * tolerance};
    ValueLattice coarser = *this;
    const double power = power_of_ten(digits);
    double units = std::min(std::floor(tolerance * power), 0x1p40);
    if (units / power > tolerance) units -= 1;
    coarser.multiple = 2 * static_cast<std::int64_t>(units) + 1;
    return coarser;
}

double ValueLattice::value(std::int64_t k) const {
    switch (kind) {
        case Kind::Decimal:
            return static_cast<double>(k) * static_cast<double>(multiple) / power_of_ten(digits);
        case Kind::Step:
            return static_cast<double>(k) * step;
        case Kind::Float32:
            return float_at(k);
        default:
            return double_at(k);
    }
}

std::int64_t ValueLattice::nearest(double value) const {
    switch (kind) {
        case Kind::Decimal: {
            const std::int64_t units = rounded(value * power_of_ten(digits));
            const std::int64_t k = (std::abs(units) + (multiple - 1) / 2) / multiple;
            return units < 0 ? -k : k;
        }
        case Kind::Step:
            return rounded(value / step);
        case Kind::Float32:
            return float_ordinal_of(
                static_cast<float>(std::clamp(value, -kLargestFloat, kLargestFloat)));
        default:
            return ordinal_of(value);
    }
}

ValueLattice lattice_within(std::span<const double> values, double tolerance) {
    const ValueLattice exact = ValueLattice::exact(values);
    double aim = tolerance;
    for (int k = 0; k < 8 && aim > 0; ++k, aim *= 0.999) {
        const ValueLattice lattice = exact.within(aim);
        if (lattice.kind == ValueLattice::Kind::Decimal && lattice.multiple == 1) break;
        const bool holds = std::all_of(values.begin(), values.end(), [&](double value) {
            return std::abs(value - lattice.value(lattice.nearest(value))) <= tolerance;
        });
        if (lattice.step > 0 && holds) return lattice;
    }
    return exact;
}

}  // namespace relief::codec
