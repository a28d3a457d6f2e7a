#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace relief::io::detail {

/// Rows of numbers with equal rows taken as one.
struct Welded {
    std::vector<std::int32_t> numbers;  ///< for each row which distinct one it is
    std::vector<std::int32_t> firsts;   ///< the distinct ones, by their first appearance
};

/// Compares rows of `width` numbers, none of them NaN; -0 equals 0. Requires: at most 2^31 - 1
/// rows. Sorting, O(n log n), because a table of hashes can be made slow by a file.
[[nodiscard]] Welded weld(std::span<const double> rows, std::size_t width);

}  // namespace relief::io::detail
