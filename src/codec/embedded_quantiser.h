#pragma once

#include <cstdint>

#include "codec/embedded_coder.h"
#include "relief/core/grid.h"

/// From the real coefficients of a band to the integers of an embedded stream, and back. The step
/// of a band is the step of the file over the norm of the band's basis functions.
namespace relief::codec {

/// q = floor(|c| / step + 0.45) with the sign of c, at most 2^31 - 1 in magnitude: values within
/// 0.55 steps of 0 become 0. `worth` gets, where |q| = 1, how much the squared error would grow if
/// q became 0, in steps^2 / 64; elsewhere 0. Requires: views of one size; c finite; step > 0.
/// Complexity: O(coefficients), parallel by rows. T: float or double.
template <class T>
void quantise_band(GridView<const T> c, double step, GridView<std::int32_t> q,
                   GridView<std::uint8_t> worth);

/// What the known bits of q stand for: q * step if all are known, otherwise the middle of what they
/// leave open, (prefix + 1/2) 2^p * step for a q that is known down to plane p and not yet 0.
/// Requires and complexity: as quantise_band.
template <class T>
void reconstruct_band(GridView<const std::int32_t> q, const KnownBits& known, double step,
                      GridView<T> c);

}  // namespace relief::codec
