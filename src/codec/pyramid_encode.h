#pragma once

#include "relief/codec/raster_codec.h"

namespace relief::codec {

/// The open loop: analysis of the whole raster in memory, choice of coefficients, quantising,
/// corrections where the goal is a bound. Errors: those of encode_raster.
[[nodiscard]] Result<EncodedRaster> encode_pyramid(const Raster& raster,
                                                   const multires::SchemeSpec& spec,
                                                   const EncodeOptions& options);

/// detail_energy for a scheme of the open loop.
[[nodiscard]] Result<double> pyramid_energy(const Raster& raster, const multires::SchemeSpec& spec);

}  // namespace relief::codec
