#pragma once

#include <cstdint>
#include <vector>

#include "relief/codec/oracle.h"

/// From real coefficients to integers and back. The step of a band is inversely proportional to its
/// norm, so that every quantised coefficient risks the same error at the samples.
namespace relief::codec {

/// values[band][component]; a coefficient is value * step of its band.
struct Quantised {
    std::vector<std::vector<Grid<std::int32_t>>> values;
    std::vector<float> steps;
    std::int64_t kept =
        0;  ///< lattice positions with a component that is not zero, scaling band included
};

/// Uniform quantiser with a dead zone: |q| = floor(|c| / step + rounding), step = unit / norm of
/// the band. The scaling band is rounded to nearest. Requires: unit > 0, 0 < rounding <= 0.5. Steps
/// are raised where 31 bits would not do.
[[nodiscard]] Quantised quantise(const Pyramid<double>& pyramid, double unit, double rounding);

/// Fine quantiser for chosen coefficients: each band's step is 2^-24 of its largest magnitude.
[[nodiscard]] Quantised quantise_finely(const Pyramid<double>& pyramid);

/// Fills an allocated pyramid; bands of levels below `finest_level` become zero.
void dequantise(const Quantised& quantised, Pyramid<double>& pyramid, int finest_level = 0);

/// Which coefficients are not zero, scaling band included.
[[nodiscard]] std::int64_t count_kept(const Quantised& quantised);

}  // namespace relief::codec
