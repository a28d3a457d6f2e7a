#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/stream.h"
#include "relief/core/vec2.h"

/// Places of vertices in files: docs/format.md, "Places".
namespace relief::codec {

/// A place as two integers of at most 2^50 in magnitude.
struct GridPlace {
    std::int64_t x = 0;
    std::int64_t y = 0;

    friend bool operator==(const GridPlace&, const GridPlace&) = default;
};

/// Places on a grid, in no order: how many lie in each half of a box is coded, then in each half
/// of the halves. Costs what it takes to tell one set of so many places from the others, about
/// log2(n) bits a place less than a list. Complexity: O(n) for each of at most 102 halvings.
[[nodiscard]] Bytes write_place_set(std::vector<GridPlace> places);
/// In the order of the halving. Errors: BadFile. Memory: O(count).
[[nodiscard]] Result<std::vector<GridPlace>> read_place_set(std::span<const std::uint8_t> bytes,
                                                            std::uint64_t count);
/// The order of the halving.
void sort_places(std::vector<GridPlace>& places);

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
