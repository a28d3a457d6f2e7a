#pragma once

#include <algorithm>
#include <cstdint>

namespace relief::multires {

/// Rows of the strips that a level of `rows` rows is cut into: at most 128, so that all rows in
/// work stay in a core's own cache, and enough that the rows computed twice at borders (about 6)
/// hardly count. Strips come in fours because two or four threads then share them evenly.
constexpr std::int64_t strip_rows(std::int64_t rows) {
    const std::int64_t strips = 4 * ((rows + 511) / 512);
    return std::max<std::int64_t>(32, (rows + strips - 1) / strips);
}

}  // namespace relief::multires
