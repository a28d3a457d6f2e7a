#pragma once

#include "relief/codec/raster_codec.h"

/// The open loop of scheme `cubic` for rasters that do not fit in memory. docs/codec.md, "Rasters
/// larger than memory".
namespace relief::codec {

/// Whether encode_tiles can do what is asked: goals rms-error above 0 and bytes, at least four
/// levels, splines that are not exact.
[[nodiscard]] bool fits_tiles(const Raster& about, int components,
                              const multires::SchemeSpec& spec, const Goal& goal);

/// As encode_pyramid, in blocks of a few tiles: the three finest levels of a block are chosen
/// together, over what is left of the coarser ones, which are chosen first and for the whole
/// raster. Every step that is tried reads the raster once. What is written is decoded and measured.
/// Memory: a few megabytes for each column of blocks, and the coarser levels, a 64th of the
/// samples; with a mask, one byte a sample. Errors: those of encode_raster, source and spool.
[[nodiscard]] Result<EncodeReport> encode_tiles(const RasterSource& source,
                                                const multires::SchemeSpec& spec,
                                                const EncodeOptions& options, ByteSink& sink,
                                                Spool& spool);

}  // namespace relief::codec
