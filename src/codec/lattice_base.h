#pragma once

#include <cstdint>
#include <span>

#include "codec/lattice_level.h"
#include "relief/core/stream.h"

/// The coarsest lattice of the closed loop: a few samples, each predicted from its west and north
/// neighbours. docs/format.md, "Levels".
namespace relief::codec {

/// Fills level.values with what decoding gives. `source`: the level's samples.
[[nodiscard]] Bytes encode_base(LatticeLevel& level, GridView<const std::int32_t> source);

/// Errors: BadFile.
[[nodiscard]] Status decode_base(std::span<const std::uint8_t> bytes, LatticeLevel& level);

}  // namespace relief::codec
