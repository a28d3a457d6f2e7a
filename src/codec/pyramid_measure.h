#pragma once

#include <functional>

#include "codec/pyramid_blocks.h"
#include "codec/surface_error.h"

/// How far a file of scheme `cubic` is off, measured by decoding it in windows.
namespace relief::codec {

/// A raster in windows that tile it.
struct Reference {
    const RasterSource& source;
    const std::vector<LatticeBox>& windows;
    std::function<bool()> cancelled = {};  ///< asked before each window
};

/// Errors of what `file` decodes to, seeing its first `visible` bytes. Errors: those of the file,
/// which must decode, and of the source; Cancelled.
[[nodiscard]] Result<SurfaceError> measured(
    const Reference& reference, const std::shared_ptr<const ByteSource>& file,
    std::uint64_t visible = std::numeric_limits<std::uint64_t>::max());

/// For each level 1 .. levels the largest error, at all samples, of the surface without details of
/// that level and finer ones, or of the raster of the level, whichever is larger; and the squared
/// error of the coarsest of these surfaces.
struct LevelErrors {
    std::vector<double> largest;
    double coarsest_square = 0;
};
[[nodiscard]] Result<LevelErrors> measured_levels(const Reference& reference,
                                                  const multires::PyramidLayout& layout,
                                                  const PyramidBlocks& blocks);

}  // namespace relief::codec
