#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "codec/ps_place_set.h"
#include "relief/core/vec2.h"

/// Places of vertices in files: docs/format.md, "Places".
namespace relief::codec {

/// Places whose order does not matter: those along lines as chains, the others as a set.
/// Complexity: O(n log n).
[[nodiscard]] Bytes write_places(std::vector<GridPlace> places);
/// In any order. Errors: BadFile. Memory: O(count).
[[nodiscard]] Result<std::vector<GridPlace>> read_places(std::span<const std::uint8_t> bytes,
                                                         std::uint64_t count);

/// How coordinates become integers. A triangulation has its places relative to its origin, x, and
/// the source had them in its own frame: x = place - origin.
struct PlaceGrid {
    /// Integers are decimals with so many digits after the point, in the source's frame.
    std::optional<int> digits;
    /// Without digits, integers are multiples of 2^exponent relative to the origin. With digits, x
    /// was rounded to such multiples; none: not rounded.
    std::optional<int> exponent;
    /// None, with digits only: the centre of the bounding box.
    std::optional<Vec2> origin;

    /// What an integer stands for: a place in the source's frame, or x without digits.
    [[nodiscard]] Vec2 place(GridPlace k) const;
    [[nodiscard]] GridPlace nearest(Vec2 place) const;
    /// Rounded as x was. Requires: digits.
    [[nodiscard]] Vec2 rounded(Vec2 x) const;
};

}  // namespace relief::codec
