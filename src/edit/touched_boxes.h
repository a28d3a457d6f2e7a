#pragma once

#include <vector>

#include "relief/multires/edit.h"

namespace relief::edit {

/// The parts of the finest lattice that moves of `level` and coarser ones can change: boxes that
/// together are little larger than the moves' own. Complexity: O(moves).
[[nodiscard]] std::vector<LatticeBox> touched_boxes(const multires::PyramidLayout& layout,
                                                    const std::vector<multires::Move>& moves,
                                                    int level);

/// How many lattice points are in at least one of a few boxes.
[[nodiscard]] std::uint64_t covered(const std::vector<LatticeBox>& boxes);

}  // namespace relief::edit
