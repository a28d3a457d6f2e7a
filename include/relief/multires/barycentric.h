#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "relief/multires/filters.h"
#include "relief/multires/pyramid.h"
#include "relief/multires/workspace.h"

/// Scheme `barycentric`: multiresolution of box-spline coefficients on the triangular lattice with
/// one scaling function and seven wavelets, the projections of tensor-product wavelets along
/// (1,1,1). Each level runs three directional passes along e1, e2, e3, fused over tiles, exactly
/// equal to convolution with the hexagonal kernels. Borders: extend and retain. See
/// docs/barycentric.md and the specification's sections 3 to 5.
namespace relief::multires::barycentric {

/// Bands "aaa" of the coarsest level, then "aab" .. "bbb" of each level, coarsest first. Norms are
/// left at 1. levels -1: one if it makes the number of scaling coefficients fall, more as long as
/// each divides it by 3.3.
[[nodiscard]] Result<PyramidLayout> layout(const SchemeSpec& spec, std::int64_t rows,
                                           std::int64_t cols, int components);

/// The boxes of the 8 channels of the level below a fine box: each keeps exactly the coefficients
/// whose synthesis kernel can reach the fine box.
[[nodiscard]] std::array<LatticeBox, 8> channel_boxes(const FilterBank& bank,
                                                      const LatticeBox& fine);

/// Scaling coefficients of `first_level` (0: the finest) to the bands of `component` above that
/// level, in `out` (allocated). Complexity: O(coefficients); scratch memory: 5/16 of the scaling
/// coefficients, and for exact semi-orthogonal analysis a padded copy.
template <class T>
void analyse(GridView<const T> scaling, int component, Pyramid<T>& out, int first_level = 0);
template <class T>
void analyse(GridView<const T> scaling, int component, Pyramid<T>& out, Workspace<T>& workspace,
             int first_level = 0);

/// The scaling coefficients of `level` on the box of that level (level 0: the raster's).
template <class T>
[[nodiscard]] Grid<T> coefficients(const Pyramid<T>& pyramid, int component, int level);

/// The same into a kept buffer; `out` has the size of that level's box.
template <class T>
void coefficients(const Pyramid<T>& pyramid, int component, int level, GridView<T> out,
                  Workspace<T>& workspace);

/// The box of the scaling coefficients of `level`.
[[nodiscard]] LatticeBox level_box(const PyramidLayout& layout, int level);

/// For each band, which part of the squared norm of each atom lies on the raster: 1 inside, less in
/// the ring of coefficients beyond the border. Estimated level by level without the cross terms of
/// overlapping atoms. Complexity: O(coefficients), arithmetic for border coefficients only.
[[nodiscard]] std::vector<Grid<float>> coverage(const PyramidLayout& layout);

/// Transpose of coefficients(., component, 0) as a linear map of all bands.
template <class T>
void adjoint(GridView<const T> residual, int component, Pyramid<T>& out);

}  // namespace relief::multires::barycentric
