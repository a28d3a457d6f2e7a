#pragma once

#include <string>

#include "relief/core/raster.h"
#include "relief/core/result.h"
#include "relief/io/image.h"

namespace relief::io {

/// Reads a picture (GeoTIFF, PNG, JPEG, WebP, BMP, GIF or JPEG 2000) to be laid over a raster:
/// RGBA, at most `largest` pixels a side. Grey and palettes become colours; samples of other types
/// than bytes are stretched to them; holes are transparent. If picture and raster both have a CRS
/// and a transform, the result covers the raster's cells, row 0 along its first row, transparent
/// where the picture does not reach; otherwise, and with terrain == nullptr, it is the picture as
/// it is. Of `terrain` only size and georeference are looked at. Nothing but the file is opened.
/// Errors: NotFound; BadInput (not one of these formats, no band, no overlap is none); BadFile
/// (damaged). Complexity: O(pixels of the picture, and of the result).
[[nodiscard]] Result<Image> read_drape(const std::string& path, const Raster* terrain, int largest);

}  // namespace relief::io
