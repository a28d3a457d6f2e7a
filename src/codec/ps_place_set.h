#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/stream.h"

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

}  // namespace relief::codec
