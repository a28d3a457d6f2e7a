#pragma once

#include <cstdint>

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/multires/pyramid.h"
#include "relief/multires/workspace.h"

/// Scheme `box`: critically sampled lifting on the triangular lattice, after barycentric-mra.md
/// section 7. Coarse surfaces are box-spline surfaces M_111 (order 1, linear) or M_222 (order 2,
/// quartic C2); a level has one wavelet for each edge direction (1,0), (0,1), (1,1). A raster of
/// one row or one column is a spline curve. docs/box.md has the formulas.
namespace relief::multires::box {

/// The bands of a rows x cols raster: "scaling" of the coarsest level, then "edge1", "edge2",
/// "edge3" of every level from the coarsest to 1. Coefficient (i, j) of edge k is that of the edge
/// from coarse (i, j) to (i, j) + step_k, steps (1,0), (0,1), (1,1). A side of n becomes n / 2 + 1;
/// a side of even length gets one extrapolated line first, which is why a level has up to rows +
/// cols + 1 coefficients more than samples (none if both sides are odd). levels -1: until both
/// sides are at most 2. Norms are left at 1. Errors: InvalidArgument for an order other than 1 and
/// 2, components outside 1 .. 4, or more levels than the size allows; BadInput for an empty raster
/// or a side beyond 2^31 - 1. Complexity: O(levels).
[[nodiscard]] Result<PyramidLayout> layout(const SchemeSpec& spec, std::int64_t rows,
                                           std::int64_t cols, int components);

using multires::Workspace;

/// Finest scaling coefficients to the bands of `component`. Reconstruction is exact up to rounding.
/// Requires: `out` allocated for a layout of this scheme; `finest` finite and of its size.
/// With first_level above 0 `finest` holds the scaling coefficients of that level, and only the
/// bands above it are written. Complexity: O(samples); memory beyond the pyramid: 5/16 of the
/// samples, and some rows.
template <class T>
void analyse(GridView<const T> finest, int component, Pyramid<T>& out);
template <class T>
void analyse(GridView<const T> finest, int component, Pyramid<T>& out, Workspace<T>& workspace,
             int first_level = 0);

/// The scaling coefficients of `level`, 0 (the raster's lattice) .. levels (a copy of the scaling
/// band), from all coarser bands. Complexity: O(coefficients of that level).
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

}  // namespace relief::multires::box
