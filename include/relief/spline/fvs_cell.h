#pragma once

#include <array>

#include "relief/spline/fvs_grid.h"

/// The unit cell of a C1 cubic spline: which 16 numbers fix it, and how.
namespace relief::spline {

inline constexpr int kFvsCellNumbers = 16;

/// Where a number of a cell stands: planes[plane](cell row + row, cell column + col).
struct FvsCellNumber {
    int plane;
    int row;
    int col;
};

/// Corners run (0, 0), (1, 0), (1, 1), (0, 1) in (x, y), sides bottom (y = 0), right, top, left.
inline constexpr std::array<FvsCellNumber, kFvsCellNumbers> kFvsCell = {{{kFvsF, 0, 0},
                                                                         {kFvsF, 0, 1},
                                                                         {kFvsF, 1, 1},
                                                                         {kFvsF, 1, 0},
                                                                         {kFvsFx, 0, 0},
                                                                         {kFvsFx, 0, 1},
                                                                         {kFvsFx, 1, 1},
                                                                         {kFvsFx, 1, 0},
                                                                         {kFvsFy, 0, 0},
                                                                         {kFvsFy, 0, 1},
                                                                         {kFvsFy, 1, 1},
                                                                         {kFvsFy, 1, 0},
                                                                         {kFvsGh, 0, 0},
                                                                         {kFvsGv, 0, 1},
                                                                         {kFvsGh, 1, 0},
                                                                         {kFvsGv, 0, 0}}};

/// The weights of a cell's numbers in the value at (i, j), 0 <= i, j <= 1; cells of size 1.
[[nodiscard]] std::array<double, kFvsCellNumbers> fvs_value_weights(double i, double j);

/// Integrals over the unit cell of the products of its 16 basis functions. Exact up to rounding;
/// the same bits everywhere.
[[nodiscard]] const std::array<std::array<double, kFvsCellNumbers>, kFvsCellNumbers>&
fvs_cell_mass();

/// bounds(r, c) = the largest absolute Bezier ordinate of cell (r, c), which |spline| there does
/// not exceed. NaN if one of the cell's numbers is NaN. Requires: bounds is ny x nx.
/// Complexity: O(cells), vectors along x, one thread.
template <class T>
void fvs_ordinate_bounds(const FvsGridView<const T>& grid, GridView<T> bounds);

}  // namespace relief::spline
