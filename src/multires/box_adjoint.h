#pragma once

#include <array>

#include "multires/box_factors.h"
#include "multires/box_rules.h"
#include "relief/core/grid.h"

/// The transposed steps of one level's synthesis, on whole planes. The update factors need them
/// too: the integrals of the basis functions are the transpose applied to the integrals of the
/// finer level.
namespace relief::multires::box {

template <class T>
using EdgePlanes = std::array<GridView<T>, kEdgeKinds>;

/// Transpose of the vertex step, edge side: edges += ring weights * vertices.
template <class T>
void spread_vertices(int order, Lattice lattice, GridView<const T> vertices,
                     const EdgePlanes<T>& edges);

/// Transpose of the vertex step's own part and of the prediction: vertices = centre * vertices +
/// prediction^T edges.
template <class T>
void collect_edges(int order, Lattice lattice, const EdgePlanes<const T>& edges,
                   GridView<T> vertices);

/// Transpose of the update without its factors: for the n edges (kind, row, 0 ..), the weighted sum
/// of their targets.
template <class T>
void collect_targets(int order, GridView<const T> vertices, int kind, std::int64_t row,
                     std::int64_t n, T* sums);

/// The transpose of synthesise_level: fine residuals to vertices and edges of its sizes.
template <class T>
void transpose_level(int order, const UpdateFactors& factors, GridView<const T> fine,
                     GridView<T> vertices, const EdgePlanes<T>& edges);

}  // namespace relief::multires::box
