#pragma once

#include "relief/core/grid.h"

namespace relief::codec {

/// A copy of `plane` whose holes (mask 0) are filled smoothly from their surroundings: averages of
/// valid samples on coarser and coarser grids, interpolated back. An empty mask copies. Requires:
/// at least one valid sample. Complexity: O(samples).
[[nodiscard]] Grid<double> filled(GridView<const double> plane, const Grid<std::uint8_t>& mask);

}  // namespace relief::codec
