#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "codec/integer_domain.h"

/// Rows of samples on their way to the closed loop's integers and back. Vector kernels with scalar
/// twins (relief/core/simd.h), equal to the bit.
namespace relief::codec {

/// out[k] = the v nearest to samples[k], ties to even, clamped to 0 .. highest; 0 for NaN.
void integer_row(const double* samples, std::int64_t n, const IntegerDomain& domain,
                 std::int32_t* out);

/// out[k] = domain.value(v[k]).
void value_row(const std::int32_t* v, std::int64_t n, const IntegerDomain& domain, double* out);

/// out[k] = the multiple of unit nearest to samples[k], ties to even.
void lattice_row(const double* samples, std::int64_t n, double unit, double* out);

/// How many valid samples a lattice does not give back, as it stores them: not to the bit if bound
/// is 0, else beyond the bound or beyond rounding.
std::int64_t count_off(const double* stored, const double* samples, const std::uint8_t* valid,
                       std::int64_t n, double bound);

/// A decoded sample keeps the bound, which for 0 means the same bits.
[[nodiscard]] inline bool is_within(double decoded, double wanted, double bound) {
    const double error = std::abs(decoded - wanted);
    if (bound > 0) return error <= bound;
    return error == 0 && std::signbit(decoded) == std::signbit(wanted);
}

struct RowErrors {
    double largest;
    bool within;  ///< all keep the bound
};
/// errors[k] = |decoded[k] - wanted[k]|, 0 in holes (valid[k] = 0; valid may be null: no holes).
RowErrors error_row(const double* decoded, const double* wanted, const std::uint8_t* valid,
                    std::int64_t n, double bound, double* errors);

/// Sums of every eighth number of a row: additions that need not wait for each other.
using PartialSums = std::array<double, 8>;
/// Adds (samples[k] - (first + k slope))^2 to sums[k % 8], but for holes.
void add_squares(const double* samples, const std::uint8_t* valid, std::int64_t n, double first,
                 double slope, PartialSums& sums);

/// The largest |a[k] - b[k]| outside of holes. Requires: differences fit 32 bits.
std::int32_t largest_difference(const std::int32_t* a, const std::int32_t* b,
                                const std::uint8_t* valid, std::int64_t n);

/// The smallest and the largest valid sample, and whether all valid ones are finite; with none,
/// lowest > highest.
struct RowRange {
    double lowest;
    double highest;
    bool finite;
};
RowRange range_of_row(const double* samples, const std::uint8_t* valid, std::int64_t n);

}  // namespace relief::codec
