#pragma once

#include <cstdint>

#include "relief/core/raster.h"

/// How far one raster is from another, sample by sample.
namespace relief::codec {

struct Measure {
    std::int64_t samples =
        0;  ///< compared: valid in both, all components of a sample counting as one
    std::int64_t mask_differs = 0;  ///< samples that are a hole in one raster only
    double max_error = 0;           ///< largest absolute difference of a component
    double mean_square = 0;  ///< mean over samples of the squared distance (summed over components)
    double rms_error = 0;    ///< its root
    double psnr_db = 0;  ///< 20 log10(range of the reference / rms_error); infinite without error
    double range = 0;    ///< largest minus smallest value of the reference
    std::int64_t worst_row = 0;  ///< where max_error is
    std::int64_t worst_col = 0;
};

/// Errors: BadInput when sizes or component counts differ, or no sample is valid in both.
/// Complexity: O(samples), parallel; the same result for any thread count.
[[nodiscard]] Result<Measure> measure(const Raster& reference, const Raster& other);

}  // namespace relief::codec
