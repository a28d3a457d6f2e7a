#pragma once

#include <cstdint>

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/multires/pyramid.h"
#include "relief/spline/fvs_grid.h"

/// Scheme `fvs`: C1 cubic splines with the hierarchical transform of
/// relief/multires/fvs_grid_transform.h, L2-stable update included. Samples are the values at the
/// vertices of the finest level; their derivatives are estimated (spline::estimate_fvs_grid), so
/// that a pyramid has about five coefficients a sample. The scaling coefficients of a level are its
/// values at the lattice points.
namespace relief::multires::fvs {

/// Bands of a rows x cols raster: "scaling", the values of the coarsest level, channel 0; its
/// derivatives "fx", "fy", "gh", "gv", channels 1 .. 4; then for each level the 15 kinds of detail
/// ("ehv" .., channels 5 .. 19). Without levels there are no derivatives. Derivatives are per
/// sample. A side of n cells becomes (n + 1) / 2. levels -1: until a side has one cell (sides of
/// one sample do not count), at most 8. Norms are those of single coefficients far from the border.
/// Errors: InvalidArgument for an order other than 2, a data map other than Interpolate, components
/// outside 1 .. 4, or more levels than halve the longer side to one cell; BadInput for an empty
/// raster or a side beyond 2^31 - 1. Complexity: O(levels) after the first call.
[[nodiscard]] Result<PyramidLayout> layout(const SchemeSpec& spec, std::int64_t rows,
                                           std::int64_t cols, int components);

/// Values of the lattice of `first_level` (0: the raster) to the bands of `component` above it; the
/// others are not touched. Requires: `out` allocated for a layout of this scheme; values finite, of
/// the size of that lattice. Reconstruction is exact up to rounding. Complexity: O(samples); memory
/// beyond the pyramid: nodal data of two levels.
template <class T>
void analyse(GridView<const T> values, int component, Pyramid<T>& out, int first_level = 0);

/// Nodal data of `level`, 0 .. levels, from all coarser bands; cells of 2^level samples.
/// Complexity: O(samples of that level).
template <class T>
[[nodiscard]] spline::FvsGrid<T> nodal_data(const Pyramid<T>& pyramid, int component, int level);

/// The values among them: the scaling coefficients of `level`.
template <class T>
[[nodiscard]] Grid<T> coefficients(const Pyramid<T>& pyramid, int component, int level);

/// The values at level `to` <= `from` of the surface through values of level `from`, whose
/// derivatives are estimated on its lattice. Requires: values of the size of that lattice.
template <class T>
[[nodiscard]] Grid<T> subdivide(const PyramidLayout& layout, GridView<const T> values, int from,
                                int to);

/// The transpose of coefficients(., ., 0) as a linear map of all bands: <coefficients(z), r> = <z,
/// adjoint(r)>. Requires and complexity: as analyse.
template <class T>
void adjoint(GridView<const T> finest_residual, int component, Pyramid<T>& out);

/// Whether analysis of a change of the values of `level` changes a band: all bands above it, and
/// the derivatives of the coarsest level with its values.
[[nodiscard]] bool follows_values_of(const PyramidLayout& layout, const BandLayout& band,
                                     int level);

/// What moving one value of a lattice does to the surface through its values: the cardinal function
/// of that value (1 there, 0 at the others, derivatives estimated), at the samples of the raster.
struct CardinalFunction {
    LatticeBox box;       ///< the samples that it can change
    Grid<double> values;  ///< the function on that box
};

/// The lattice of `level` of a raster of rows x cols has ceil((rows - 1) / 2^level) + 1 rows, and
/// columns alike; the last may lie beyond the raster. Errors: InvalidArgument for a level that has
/// no lattice of 2 x 2 points or a value that does not exist. Complexity: O(box).
[[nodiscard]] Result<CardinalFunction> cardinal_function(std::int64_t rows, std::int64_t cols,
                                                         int level, std::int64_t row,
                                                         std::int64_t col);

/// The first and last of n lattice points whose neighbouring cells change with the value at k.
struct LatticeRange {
    std::int64_t first;
    std::int64_t last;
};
[[nodiscard]] LatticeRange cardinal_support(std::int64_t k, std::int64_t n);

}  // namespace relief::multires::fvs
