#pragma once

#include <cstdint>

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/multires/pyramid.h"
#include "relief/multires/workspace.h"

/// Scheme `cubic`: bicubic C2 splines in cardinal form by separable lifting, after
/// codec-open-loop.md section 2. The scaling coefficients of a level ARE the values of its surface
/// at the lattice points; odd samples are predicted by the spline through the even ones, and the
/// update is half the adjoint of that. Beyond the border samples continue by whole-sample mirror.
/// relief/multires/cubic_window.h has the same transform on parts of a raster; docs/cubic.md the
/// formulas.
namespace relief::multires::cubic {

/// The bands of a rows x cols raster, with their norms: "scaling" of the coarsest level, then
/// "odd-x" (odd columns of even rows), "odd-y" (even columns of odd rows), "odd-xy" of every level
/// from the coarsest to 1. A side of n has (n + 1) / 2 even and n / 2 odd samples, so there are as
/// many coefficients as samples, and bands without rows or columns if a side is 1. levels -1: while
/// the shorter side that is not 1 is at least 4 after halving, at most 7. Errors: InvalidArgument
/// for an order other than 2, a data map other than Interpolate, components outside 1 .. 4, or more
/// levels than it takes to reach one sample; BadInput for an empty raster or a side beyond 2^31 -
/// 1. Complexity: O(levels).
[[nodiscard]] Result<PyramidLayout> layout(const SchemeSpec& spec, std::int64_t rows,
                                           std::int64_t cols, int components);

/// Values of the finest lattice to the bands of `component`. Reconstruction is exact up to
/// rounding. Requires: `out` allocated for a layout of this scheme; `finest` finite and of its
/// size. With first_level above 0 `finest` holds the values of that level, and only the bands above
/// it are written. Complexity: O(samples); memory beyond the pyramid: 5/16 of the samples, and some
/// rows a thread.
template <class T>
void analyse(GridView<const T> finest, int component, Pyramid<T>& out);
template <class T>
void analyse(GridView<const T> finest, int component, Pyramid<T>& out, Workspace<T>& workspace,
             int first_level = 0);

/// The values of `level`, 0 (the raster's lattice) .. levels (a copy of the scaling band), from all
/// coarser bands. Complexity: O(values of that level).
template <class T>
[[nodiscard]] Grid<T> coefficients(const Pyramid<T>& pyramid, int component, int level);

/// The same into a kept buffer; `out` has the size of that level.
template <class T>
void coefficients(const Pyramid<T>& pyramid, int component, int level, GridView<T> out,
                  Workspace<T>& workspace);

/// The transpose of coefficients(., ., 0) as a linear map of all bands: <coefficients(z), r> = <z,
/// adjoint(r)>. Requires and complexity: as analyse.
template <class T>
void adjoint(GridView<const T> finest_residual, int component, Pyramid<T>& out);

}  // namespace relief::multires::cubic
