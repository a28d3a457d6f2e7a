#pragma once

#include <cstdint>

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/spline/fvs_grid.h"

/// Certified bounds of C1 cubic splines: a spline does not exceed its Bezier ordinates, and
/// refinement brings these close to it. Ordinates exceed the maximum by some ten percent without
/// refinement on smooth surfaces (up to 1.5 times on rough ones), by 2 to 6 percent after one, by
/// about one percent after two.
/// Source: specification of hierarchical FVS splines, section 8.1.
namespace relief::multires::fvs {

inline constexpr int kMostRefinements = 4;

/// bounds(r, c) >= |spline| on cell (r, c), up to rounding, from the ordinates after `refinements`
/// halvings of the cells. NaN where data are not finite. Errors: InvalidArgument for refinements
/// outside 0 .. kMostRefinements. Complexity: O(4^refinements cells), in parallel.
template <class T>
[[nodiscard]] Result<Grid<T>> cell_bounds(const spline::FvsGridView<const T>& grid,
                                          int refinements);

/// An upper bound of max |u - v| over the window, u and v the C1 cubic splines through two rasters
/// (spline::estimate_fvs_grid); 1e-13 of the largest sample is added for rounding. The largest
/// bound of windows that together cover the cells of a raster is that of the raster: it can be
/// certified in bands of rows. Both parts must cover spline::needed_box(window).
/// Errors: InvalidArgument for refinements outside 0 .. kMostRefinements, rasters that differ in
/// size, or a window without cells or not covered; BadInput for samples that are not finite.
/// Complexity: O(4^refinements samples), in parallel; memory for some tiles.
template <class T>
[[nodiscard]] Result<double> certify(const spline::RasterPart<T>& original,
                                     const spline::RasterPart<T>& decoded, const LatticeBox& window,
                                     int refinements = 2);

/// The same for whole rasters of one size.
template <class T>
[[nodiscard]] Result<double> certify(GridView<const T> original, GridView<const T> decoded,
                                     int refinements = 2);

}  // namespace relief::multires::fvs
