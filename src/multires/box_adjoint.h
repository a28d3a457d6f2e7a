#pragma once

#include <array>

#include "multires/box_factors.h"
#include "multires/box_rules.h"
#include "relief/core/grid.h"

/// The transposed steps of one level's synthesis, row by row. The update factors need them too: the
/// integrals of the basis functions are the transpose applied to the integrals of the finer level.
namespace relief::multires::box {

template <class T>
using EdgePlanes = std::array<GridView<T>, kEdgeKinds>;

/// Rows of a plane of which the last `depth` are kept: row i starts at data + i % depth * stride.
template <class T>
struct RowWindow {
    T* data;
    std::int64_t rows;
    std::int64_t cols;
    std::int64_t stride;
    std::int64_t depth;

    RowWindow(T* first, std::int64_t row_count, std::int64_t col_count, std::int64_t row_stride,
              std::int64_t kept)
        : data(first), rows(row_count), cols(col_count), stride(row_stride), depth(kept) {}
    /// All rows of a plane.
    RowWindow(GridView<T> plane)  // NOLINT: implicit
        : RowWindow(plane.data, plane.rows, plane.cols, plane.stride, plane.rows) {}
    [[nodiscard]] T* row(std::int64_t i) const { return data + i % depth * stride; }
};

template <class T>
using EdgeWindows = std::array<RowWindow<T>, kEdgeKinds>;

/// Transpose of the vertex step, edge side: row i of the edges of `kind` += ring weights *
/// vertices.
template <class T>
void spread_vertices(int order, Lattice lattice, const RowWindow<const T>& vertices, int kind,
                     std::int64_t i, T* edges);

/// Transpose of the vertex step's own part and of the prediction: vertex row i = centre * itself +
/// prediction^T edges.
template <class T>
void collect_edges(int order, Lattice lattice, const EdgeWindows<const T>& edges, std::int64_t i,
                   T* vertices);

/// Vertex rows i - kUpdateReach .. i + kUpdateReach, zero outside of the lattice and in the
/// kUpdateReach elements in front of and behind each row.
inline constexpr int kTargetRows = 2 * kUpdateReach + 1;
template <class T>
using TargetRows = std::array<const T*, kTargetRows>;

/// Transpose of the update without its factors: for the n edges of row i of `kind`, the weighted
/// sum of their targets.
template <class T>
void collect_targets(int order, const TargetRows<T>& vertices, int kind, std::int64_t n, T* sums);

/// The transpose of synthesise_level: fine residuals to vertices and edges of its sizes.
template <class T>
void transpose_level(int order, const UpdateFactors& factors, GridView<const T> fine,
                     GridView<T> vertices, const EdgePlanes<T>& edges);

}  // namespace relief::multires::box
