#pragma once

#include "multires/box_adjoint.h"
#include "multires/box_factors.h"
#include "multires/row_copy.h"
#include "relief/core/grid.h"

/// One level of the transform on a raster of at least 2 x 2, as a pipeline of rows: all steps of a
/// row run while its neighbours are in the cache. Strips of rows are independent (their halos are
/// computed twice), so threads and their number do not change a byte.
namespace relief::multires::box {

/// fine -> coarse vertices and edges. vertices.rows == fine.rows / 2 + 1 and so for columns.
template <class T>
void analyse_level(int order, const UpdateFactors& factors, GridView<const T> fine,
                   GridView<T> vertices, const EdgePlanes<T>& edges);

/// Undoes analyse_level. `traffic`: whether `fine` will be read soon.
template <class T>
void synthesise_level(int order, const UpdateFactors& factors, GridView<const T> vertices,
                      const EdgePlanes<const T>& edges, Traffic traffic, GridView<T> fine);

}  // namespace relief::multires::box
