#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "relief/core/grid.h"
#include "relief/core/result.h"

/// Entropy coding of bi-level images, such as which samples of a raster are valid. docs/format.md,
/// "Mask chunks".
namespace relief::codec {

/// Every pixel that is not 0 counts as 1. An image of ones, or of rows that repeat, costs a few
/// bytes. Complexity: O(pixels).
[[nodiscard]] std::vector<std::uint8_t> encode_mask(GridView<const std::uint8_t> mask);

/// Fills `mask`, which must have the size that was encoded, with 0 and 1. Never reads past `bytes`.
/// Errors: BadFile when the bytes end too early or too late (the image is unspecified then).
Status decode_mask(std::span<const std::uint8_t> bytes, GridView<std::uint8_t> mask);

}  // namespace relief::codec
