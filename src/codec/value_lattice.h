#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace relief::codec {

/// 10^0 .. 10^15: exact doubles.
inline constexpr int kMostDigits10 = 15;
[[nodiscard]] double power_of_ten(int digits);

/// The fewest digits after the point, at most 15, with which all values are decimal numbers of
/// which a double is the nearest; none if there are no such digits. Zeros with a sign are none.
/// Complexity: O(values).
[[nodiscard]] std::optional<int> decimal_digits(std::span<const double> values);

/// The place of a double among all doubles: neighbours differ by 1, +0 is 0, -0 is -1.
[[nodiscard]] std::int64_t ordinal_of(double value);
[[nodiscard]] double double_at(std::int64_t ordinal);

/// Integers that stand for real values, near to each other for values that are.
struct ValueLattice {
    enum class Kind : std::uint8_t {
        Decimal,  ///< value = (k multiple) / 10^digits, rounded once
        Step,     ///< value = k step
        Float32,  ///< k is the value's place among all floats
        Float64,  ///< k is the value's place among all doubles
    };
    Kind kind = Kind::Float64;
    int digits = 0;
    std::int64_t multiple = 1;  ///< odd
    double step = 1;

    /// The lattice that has all values, none of them lost.
    [[nodiscard]] static ValueLattice exact(std::span<const double> values);
    /// The coarsest lattice that has, for values of the lattice `*this`, a value within `tolerance`
    /// of each: steps of 2 tolerance, or a multiple of the unit for decimals.
    [[nodiscard]] ValueLattice within(double tolerance) const;

    [[nodiscard]] double value(std::int64_t k) const;
    /// The nearest integer. Requires: a finite value. Far beyond 2^53 units: one of the right sign.
    [[nodiscard]] std::int64_t nearest(double value) const;
};

/// The coarsest lattice that has a value within `tolerance` of each of these, also after rounding
/// to doubles; that of the values themselves if there is no coarser one. Complexity: O(values).
[[nodiscard]] ValueLattice lattice_within(std::span<const double> values, double tolerance);

}  // namespace relief::codec
