#pragma once

#include "relief/spline/fvs_grid.h"

/// The parts of estimate_fvs_grid, for callers that run in parallel themselves. Private to the
/// module.
namespace relief::spline {

/// The errors of estimate_fvs_grid.
template <class T>
[[nodiscard]] Status check_fvs_window(const RasterPart<T>& part, const LatticeBox& window);

/// Fills the rows first .. last - 1 of `grid`, the nodal data of `window`.
template <class T>
void estimate_fvs_rows(const RasterPart<T>& part, const LatticeBox& window, std::int64_t first,
                       std::int64_t last, const FvsGridView<T>& grid);

}  // namespace relief::spline
