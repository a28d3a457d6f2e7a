#pragma once

#include <cstdint>
#include <string>

#include "codec/tile_codec.h"
#include "relief/codec/raster_codec.h"

namespace relief::codec {

/// What the header of a raster file says, besides the coded data.
struct RasterHeader {
    Raster description;  ///< no planes, no mask
    int components = 1;
    bool has_mask = false;
    multires::SchemeSpec spec;
    Goal goal;
    double max_error = 0;
    double rms_error = 0;
    std::optional<LatticeCoding> lattice = {};  ///< of files of the closed loop
};

[[nodiscard]] std::string_view profile_name(Profile profile);
[[nodiscard]] std::string_view goal_name(Goal::Kind kind);

/// JSON text. Members with their default values are left out.
[[nodiscard]] std::string write_header(const RasterHeader& header);

/// Errors: BadFile naming the member that is missing, of the wrong type or out of range;
/// Unsupported for other contents.
[[nodiscard]] Result<RasterHeader> read_header(const std::string& json);

}  // namespace relief::codec
