#pragma once

#include "multires/cubic_level.h"

/// One level with the whole spline instead of its taps: sums are those of the infinite cardinal
/// spline, computed by its recursion. Whole lattices only, for a recursion has no window.
namespace relief::multires::cubic {

/// As split_level; `fine` and `bands` are whole, rows x cols samples.
template <class T>
void split_level_exactly(const Lifting& lifting, GridView<const T> fine, const Bands<T>& bands);

/// As merge_level.
template <class T>
void merge_level_exactly(const Bands<const T>& bands, GridView<T> fine);

}  // namespace relief::multires::cubic
