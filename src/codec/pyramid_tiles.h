#pragma once

#include <optional>

#include "relief/codec/raster_codec.h"

/// The open loop of scheme `cubic` for rasters that do not fit in memory. docs/codec.md, "Rasters
/// larger than memory".
namespace relief::codec {

/// Whether encode_tiles can do what is asked: goals rms-error above 0 and bytes, at least four
/// levels, splines that are not exact.
[[nodiscard]] bool fits_tiles(const Raster& about, int components, const multires::SchemeSpec& spec,
                              const Goal& goal);

/// As encode_pyramid, tile by tile: the three finest levels of a tile are chosen together, over
/// what is left of the coarser ones, which are chosen first and for the whole raster. Every step
/// that is tried reads the raster once. What is written is decoded and measured. Memory: some 100
/// MB for each of four tiles, a few megabytes for each column of tiles, and the coarser levels, a
/// 64th of the samples. None: the goal is an error that is too small for any step; nothing was
/// written. Errors: those of encode_raster, source and spool.
[[nodiscard]] Result<std::optional<EncodeReport>> encode_tiles(const RasterSource& source,
                                                               const multires::SchemeSpec& spec,
                                                               const EncodeOptions& options,
                                                               ByteSink& sink, Spool& spool);

}  // namespace relief::codec
