#pragma once

#include <cstdint>

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/spline/fvs_grid.h"

/// C1 cubic splines with fewer numbers than samples.
namespace relief::multires::fvs {

/// Nodal data of cells of 2^level x 2^level samples (derivatives per sample) that minimise the sum
/// of squares of spline - value over the valid samples. mask: 1 valid, 0 hole; an empty view: all
/// valid. Where samples do not determine the spline (holes, the part of a last cell beyond the
/// raster) it continues the fit of the next coarser level; without holes the start is the spline
/// through every 2^level-th sample with estimated derivatives. Preconditioned conjugate gradients
/// on the element matrices; the same bits for any number of threads.
/// Requires: mask empty or of the size of values. Errors: InvalidArgument for a level below 1 (at
/// least 2 samples a cell and direction are needed) or one whose cells are larger than the raster,
/// or a mask of another size; BadInput for a side of less than 3 samples, no valid sample, or a
/// valid one that is not finite. Complexity: O(samples + cells iterations), 512 operations a cell
/// and iteration, in cells with holes 32 a sample; about 100 iterations.
/// Source: specification of hierarchical FVS splines, section 7.
template <class T>
[[nodiscard]] Result<spline::FvsGrid<double>> fit_fvs_grid(GridView<const T> values,
                                                           GridView<const std::uint8_t> mask,
                                                           int level);

}  // namespace relief::multires::fvs
