#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "relief/core/raster.h"

/// The integers that the closed loop codes in place of samples. Source: codec-closed-loop, section
/// 2; docs/codec.md, "Integers".
namespace relief::codec {

/// Floats in the order of their values, -0 before 0, which is number 0.
[[nodiscard]] double ordinal_of_float(float value);

/// Of the nearest finite float.
[[nodiscard]] double float_of_ordinal(double ordinal);

/// A sample is unit x (origin + v), in double and in this order, then as its type stores it.
struct IntegerDomain {
    double unit = 1;
    double origin = 0;         ///< an integer
    std::int32_t step = 1;     ///< odd: quantiser step in units
    int raw_bits = 0;          ///< of quotients, which are not worth modelling
    std::int32_t highest = 0;  ///< valid samples have v = 0 .. highest, or are repaired
    double rounding = 0;       ///< storing moves a value by at most this (the encoder's knowledge)
    /// Instead: v counts the float32 numbers from the origin-th, as ordinal_of_float counts them.
    /// Neighbours are at most a unit apart.
    bool floats = false;
    bool lattice = false;   ///< samples are multiples of the unit (but for some that are repaired)
    bool outliers = false;  ///< samples lie outside and are repaired (the encoder's knowledge)

    [[nodiscard]] double value(std::int32_t v) const {
        return floats ? float_of_ordinal(origin + v) : unit * (origin + v);
    }
};

/// What must be known of all valid samples of a component.
struct SampleStatistics {
    std::int64_t count = 0;
    double lowest = 0;
    double highest = 0;
    double step = 0;  ///< integers: greatest common divisor of the samples' differences from lowest

    void add(double sample);
    void add(const SampleStatistics& other);
};

/// A lattice on which samples might lie: its unit, to be tried in this order. None: the end.
[[nodiscard]] std::optional<double> lattice_candidate(int k);

/// The domain for samples on a lattice (unit > 0) or on none (unit 0). None when 32-bit integers
/// can not hold the samples at that resolution, or the bound is finer than the type's rounding
/// allows. bound >= 0.
[[nodiscard]] std::optional<IntegerDomain> make_domain(const SampleStatistics& statistics,
                                                       SampleType type, double unit, double bound);

/// Larger steps would leave the range of integers.
inline constexpr int kMostRawBits = 24;

/// Shares of samples that may lie off a lattice, and outside a domain.
inline constexpr double kLatticeMisfits = 0.01;
inline constexpr double kMostOutliers = 0.01;

}  // namespace relief::codec
