#pragma once

#include <span>
#include <vector>

#include "relief/core/stream.h"
#include "relief/multires/edit.h"

namespace relief::codec {

/// Every number of the displacement is at most 1e300 in magnitude.
[[nodiscard]] bool is_displacement(const multires::Move& move);

/// The edits chunk: docs/format.md, "Edits chunk".
[[nodiscard]] Bytes write_moves(const std::vector<multires::Move>& moves);

/// Errors: BadFile.
[[nodiscard]] Result<std::vector<multires::Move>> read_moves(std::span<const std::uint8_t> bytes,
                                                             const multires::PyramidLayout& layout);

}  // namespace relief::codec
