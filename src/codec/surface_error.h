#pragma once

#include <cmath>
#include <cstdint>

#include "relief/codec/raster_codec.h"
#include "relief/core/raster.h"
#include "relief/multires/pyramid.h"

/// How far surfaces are from the raster that they were made of.
namespace relief::codec {

/// Over the samples that were compared, components counting each.
struct SurfaceError {
    double max = 0;     ///< largest, in absolute value
    double square = 0;  ///< sum of squares
    [[nodiscard]] double rms(std::int64_t samples) const {
        return std::sqrt(square / static_cast<double>(samples));
    }
};

/// Errors of a surface at the valid samples, after rounding to the sample type. Same result for any
/// thread count.
[[nodiscard]] SurfaceError surface_error(const Raster& raster,
                                         const multires::Planes<double>& surface);

/// Largest error of the raster of a level, which has every 2^level-th sample.
[[nodiscard]] double largest_error_of_level(const Raster& raster,
                                            const multires::Planes<double>& planes, int level);

/// A report of the raster's and the file's sizes.
[[nodiscard]] EncodeReport size_report(const Raster& about, std::uint64_t bytes);

/// samples: that were compared. energy: squared error of the coarsest surface.
void set_errors(EncodeReport& report, const SurfaceError& error, std::int64_t samples,
                double energy);

}  // namespace relief::codec
