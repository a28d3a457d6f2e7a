#pragma once

#include "codec/lattice_level.h"

namespace relief::codec {

/// D and E samples, and the margins, as the fast codec decodes them when every q is 0: the level as
/// far as the coarser one tells it. Their quotients become 0; mask and step do not matter.
/// Complexity: O(samples).
void fill_level(LatticeLevel& level);

/// The largest |value - sample| of the next finer level, filled in like that, outside of holes.
/// `coarse`: decoded, its `lowest` 0. `valid`: empty if there are no holes. The level itself is
/// never in memory. Complexity: O(samples).
[[nodiscard]] std::int32_t largest_filling_error(LatticeLevel& coarse,
                                                 GridView<const std::int32_t> samples,
                                                 const Grid<std::uint8_t>& valid);

}  // namespace relief::codec
