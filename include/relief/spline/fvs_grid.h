#pragma once

#include <array>
#include <cstdint>

#include "relief/core/grid.h"
#include "relief/core/result.h"

/// Nodal data of C1 cubic splines on rectangular grids: every cell is cut by both diagonals into
/// four cubic triangles (the element of Fraeijs de Veubeke and Sander). x runs along columns, y
/// down the rows.
namespace relief::spline {

/// The five arrays of nodal data, as indices into `planes`.
// NOLINTBEGIN(readability-identifier-naming): constants, not names of a type
enum FvsPlane : int {
    kFvsF,   ///< value at a vertex
    kFvsFx,  ///< derivative along x at a vertex
    kFvsFy,  ///< derivative along y at a vertex
    kFvsGh,  ///< derivative along y at the midpoint of a horizontal edge
    kFvsGv,  ///< derivative along x at the midpoint of a vertical edge
};
// NOLINTEND(readability-identifier-naming)
inline constexpr int kFvsPlanes = 5;

/// Nodal data of nx x ny cells of size a x b, not owned. F, FX, FY: (ny + 1) x (nx + 1); GH: (ny +
/// 1) x nx, between vertex (r, c) and (r, c + 1); GV: ny x (nx + 1), between (r, c) and (r + 1, c).
/// Derivatives are per unit of a and b. A grid of one row or column of vertices has no cells.
template <class T>
struct FvsGridView {
    std::array<GridView<T>, kFvsPlanes> planes{};
    double a = 1;
    double b = 1;

    FvsGridView() = default;
    FvsGridView(const std::array<GridView<T>, kFvsPlanes>& views, double width, double height)
        : planes(views), a(width), b(height) {}
    /// A view of mutable data is also a view of const ones.
    template <class U>
    requires std::is_same_v<const U, T> FvsGridView(const FvsGridView<U>& o)  // NOLINT: implicit
        : a(o.a), b(o.b) {
        for (std::size_t p = 0; p < kFvsPlanes; ++p) planes[p] = o.planes[p];
    }

    [[nodiscard]] const GridView<T>& operator[](int plane) const {
        return planes[static_cast<std::size_t>(plane)];
    }
    [[nodiscard]] std::int64_t nx() const { return planes[kFvsF].cols - 1; }
    [[nodiscard]] std::int64_t ny() const { return planes[kFvsF].rows - 1; }
};

/// The same, owned. Elements are NOT initialised by the sized constructor.
template <class T>
struct FvsGrid {
    std::array<Grid<T>, kFvsPlanes> planes;
    double a = 1;
    double b = 1;

    FvsGrid() = default;
    /// Requires: nx, ny >= 0.
    FvsGrid(std::int64_t nx, std::int64_t ny, double width = 1, double height = 1)
        : planes{Grid<T>(ny + 1, nx + 1), Grid<T>(ny + 1, nx + 1), Grid<T>(ny + 1, nx + 1),
                 Grid<T>(ny + 1, nx), Grid<T>(ny, nx + 1)},
          a(width),
          b(height) {}

    [[nodiscard]] Grid<T>& operator[](int plane) { return planes[static_cast<std::size_t>(plane)]; }
    [[nodiscard]] const Grid<T>& operator[](int plane) const {
        return planes[static_cast<std::size_t>(plane)];
    }
    [[nodiscard]] std::int64_t nx() const { return planes[kFvsF].cols() - 1; }
    [[nodiscard]] std::int64_t ny() const { return planes[kFvsF].rows() - 1; }

    [[nodiscard]] FvsGridView<T> view() {
        return {{planes[0].view(), planes[1].view(), planes[2].view(), planes[3].view(),
                 planes[4].view()},
                a,
                b};
    }
    [[nodiscard]] FvsGridView<const T> view() const {
        return {{planes[0].view(), planes[1].view(), planes[2].view(), planes[3].view(),
                 planes[4].view()},
                a,
                b};
    }
};

/// Samples of a raster of rows x cols, or of a part of it: values(0, 0) is sample (row0, col0).
template <class T>
struct RasterPart {
    GridView<const T> values;
    std::int64_t row0 = 0;
    std::int64_t col0 = 0;
    std::int64_t rows = 0;
    std::int64_t cols = 0;

    static RasterPart whole(GridView<const T> values) {
        return {values, 0, 0, values.rows, values.cols};
    }
};

/// The samples on which the nodal data of `window` depend: two more on every side for derivatives,
/// which serve the midpoints too, and up to five from a border of the raster that is near.
/// Requires: the window lies in the raster.
[[nodiscard]] LatticeBox needed_box(const LatticeBox& window, std::int64_t rows, std::int64_t cols);

/// Nodal data of the spline through the samples of `window`, whose vertices are the samples.
/// Derivatives are fourth-order differences (fd4), one-sided at the border of the raster, midpoints
/// are cubic interpolation; polynomials of degree 3 are reproduced if both sides have at least 4
/// samples. Sides of 3 and 2 give a parabola and a line, a side of 1 has derivative 0. The data of
/// a window are those of the whole raster to the bit. Complexity: O(window), in parallel, vectors
/// along x.
/// Requires: finite samples. Errors: InvalidArgument if the window is empty or leaves the raster,
/// the samples do not cover needed_box(window), or a spacing is not positive.
/// Source: specification of hierarchical FVS splines, section 7.
template <class T>
[[nodiscard]] Result<FvsGrid<T>> estimate_fvs_grid(const RasterPart<T>& part,
                                                   const LatticeBox& window, double a = 1,
                                                   double b = 1);

}  // namespace relief::spline
