#pragma once

#include "relief/core/grid.h"
#include "relief/core/result.h"

/// From values of a cubic spline at the integers to its B-spline coefficients: (c(i-1) + 4 c(i) +
/// c(i+1)) / 6 = v(i), solved by a forward and a backward recursion whose factor tends to 2 -
/// sqrt(3). All functions take float or double and work in parallel over strips of lines; results
/// do not depend on the number of threads. Complexity: O(values).
namespace relief::spline {

/// How a line of n values continues at its end; at its start it is mirrored at value 0.
enum class LineEnd {
    AtLast,      ///< mirrored at the last value: v(n - 1 + k) = v(n - 1 - k)
    BehindLast,  ///< mirrored half a step behind it: v(n - 1 + k) = v(n - k)
};

/// Turns the values of every column into coefficients, in place.
template <class T>
void solve_cubic_columns(GridView<T> lines, LineEnd end);

/// The transpose of a grid of any size; `out` is cols x rows and does not overlap it.
template <class T>
void transpose(GridView<const T> grid, GridView<T> out);

/// Coefficients of the bicubic spline through `values`, mirrored at its outermost values on all
/// sides. `coefficients` may be `values`. Errors: InvalidArgument for sizes that differ, BadInput
/// for an empty grid.
template <class T>
[[nodiscard]] Status interpolate_cubic(GridView<const T> values, GridView<T> coefficients);

}  // namespace relief::spline
