#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "codec/lattice_assembly.h"
#include "codec/raster_header.h"

/// The header of a shard: docs/format.md, "Shards".
namespace relief::codec {

struct ShardTile {
    std::int64_t number = 0;
    TileSummary about;
};

struct ShardHeader {
    RasterHeader raster;     ///< its errors are not known yet
    std::int64_t valid = 0;  ///< samples
    std::optional<std::uint32_t> plan =
        {};                             ///< the checksum of the plan's head; none: this is the plan
    std::vector<ShardTile> tiles = {};  ///< ascending
};

[[nodiscard]] std::string write_shard_header(const ShardHeader& header);

/// Errors: BadFile naming the member that is missing, of the wrong type or out of range;
/// Unsupported for what is no shard.
[[nodiscard]] Result<ShardHeader> read_shard_header(const std::string& json);

}  // namespace relief::codec
