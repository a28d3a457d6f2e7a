#include "relief/multires/fvs_certificate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/multires/fvs_grid_transform.h"
#include "relief/spline/fvs_cell.h"

namespace relief::multires::fvs {

namespace {

using spline::RasterPart;

/// Cells of a tile, which with two refinements stays in a core's cache.
constexpr std::int64_t kTileRows = 16;
constexpr std::int64_t kTileCols = 128;

Status check_refinements(int refinements) {
    if (refinements >= 0 && refinements <= kMostRefinements) return {};
    return Error{
        ErrorCode::InvalidArgument,
        std::to_string(refinements) + " refinements; give 0 to " + std::to_string(kMostRefinements),
        "refinements"};
}

/// The data of cells row0 .. row0 + rows - 1, col0 .. col0 + cols - 1.
template <class T>
FvsGridView<T> cells_of(const FvsGridView<T>& grid, const LatticeBox& cells) {
    FvsGridView<T> part = grid;
    for (std::size_t p = 0; p < spline::kFvsPlanes; ++p) {
        const GridView<T>& plane = grid.planes[p];
        part.planes[p] = {plane.row(cells.row0) + cells.col0, cells.rows + (plane.rows - grid.ny()),
                          cells.cols + (plane.cols - grid.nx()), plane.stride};
    }
    return part;
}

/// Runs run(cells) for tiles of rows x cols cells.
template <class Run>
void for_tiles(std::int64_t rows, std::int64_t cols, Run run) {
    const std::int64_t across = (cols + kTileCols - 1) / kTileCols;
    const std::int64_t down = (rows + kTileRows - 1) / kTileRows;
    parallel_for(0, across * down, 1, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t k = first; k < last; ++k) {
            const std::int64_t row = k / across * kTileRows, col = k % across * kTileCols;
            run(LatticeBox{row, col, std::min(kTileRows, rows - row),
                           std::min(kTileCols, cols - col)});
        }
    });
}

/// NaN is largest of all.
template <class T>
void raise(T& largest, T value) {
    if (value > largest || value != value) largest = value;
}

/// out(r, c) = the largest bound in the 2^refinements x 2^refinements parts of a cell.
template <class T>
void tile_bounds(const FvsGridView<const T>& tile, int refinements, GridView<T> out) {
    FvsGridView<const T> current = tile;
    FvsGrid<T> finer;
    for (int k = 0; k < refinements; ++k) {
        FvsGrid<T> next(2 * current.nx(), 2 * current.ny(), current.a / 2, current.b / 2);
        predict(current, next.view());
        finer = std::move(next);
        current = std::as_const(finer).view();
    }
    if (refinements == 0) return spline::fvs_ordinate_bounds(current, out);
    Grid<T> parts(current.ny(), current.nx());
    spline::fvs_ordinate_bounds(current, parts.view());
    for (std::int64_t r = 0; r < out.rows; ++r) std::fill_n(out.row(r), out.cols, T(0));
    for (std::int64_t r = 0; r < parts.rows(); ++r)
        for (std::int64_t c = 0; c < parts.cols(); ++c)
            raise(out(r >> refinements, c >> refinements), parts(r, c));
}

template <class T>
double largest_magnitude(const RasterPart<T>& part, const LatticeBox& box) {
    double largest = 0;
    for (std::int64_t r = 0; r < box.rows; ++r) {
        const T* row = part.values.row(box.row0 + r - part.row0) + (box.col0 - part.col0);
        for (std::int64_t c = 0; c < box.cols; ++c)
            raise(largest, std::abs(static_cast<double>(row[c])));
    }
    return largest;
}

/// Differences of samples in a box, as a part of the raster.
template <class T>
Grid<double> differences(const RasterPart<T>& a, const RasterPart<T>& b, const LatticeBox& box) {
    Grid<double> result(box.rows, box.cols);
    for (std::int64_t r = 0; r < box.rows; ++r) {
        const T* from = a.values.row(box.row0 + r - a.row0) + (box.col0 - a.col0);
        const T* minus = b.values.row(box.row0 + r - b.row0) + (box.col0 - b.col0);
        for (std::int64_t c = 0; c < box.cols; ++c)
            result(r, c) = static_cast<double>(from[c]) - static_cast<double>(minus[c]);
    }
    return result;
}

template <class T>
Status check_cover(const RasterPart<T>& part, const LatticeBox& window) {
    const LatticeBox box = spline::needed_box(window, part.rows, part.cols);
    if (box.row0 >= part.row0 && box.col0 >= part.col0 &&
        box.row0 + box.rows <= part.row0 + part.values.rows &&
        box.col0 + box.cols <= part.col0 + part.values.cols)
        return {};
    return Error{ErrorCode::InvalidArgument,
                 "the samples do not cover needed_box of the window to certify", "window"};
}

/// The bound over the cells of a tile of the window.
template <class T>
double tile_bound(const RasterPart<T>& original, const RasterPart<T>& decoded,
                  const LatticeBox& vertices, int refinements) {
    const LatticeBox box = spline::needed_box(vertices, original.rows, original.cols);
    const Grid<double> difference = differences(original, decoded, box);
    const RasterPart<double> part{difference.view(), box.row0, box.col0, original.rows,
                                  original.cols};
    const auto grid = spline::estimate_fvs_grid(part, vertices);
    Grid<double> bounds(grid->ny(), grid->nx());
    tile_bounds<double>(grid->view(), refinements, bounds.view());
    return largest_magnitude(RasterPart<double>::whole(bounds.view()),
                             {0, 0, bounds.rows(), bounds.cols()});
}

}  // namespace

template <class T>
Result<Grid<T>> cell_bounds(const FvsGridView<const T>& grid, int refinements) {
    RELIEF_CHECK(check_refinements(refinements));
    Grid<T> bounds(grid.ny(), grid.nx());
    for_tiles(grid.ny(), grid.nx(), [&](const LatticeBox& cells) {
        tile_bounds<T>(
            cells_of(grid, cells), refinements,
            {bounds.row(cells.row0) + cells.col0, cells.rows, cells.cols, bounds.stride()});
    });
    return bounds;
}

template <class T>
Result<double> certify(const RasterPart<T>& original, const RasterPart<T>& decoded,
                       const LatticeBox& window, int refinements) {
    RELIEF_CHECK(check_refinements(refinements));
    if (original.rows != decoded.rows || original.cols != decoded.cols)
        return Error{ErrorCode::InvalidArgument, "the rasters to compare differ in size",
                     "rasters"};
    if (window.rows < 2 || window.cols < 2 || window.row0 < 0 || window.col0 < 0 ||
        window.row0 + window.rows > original.rows || window.col0 + window.cols > original.cols)
        return Error{ErrorCode::InvalidArgument,
                     "the window to certify has no cell or leaves the raster", "window"};
    RELIEF_CHECK(check_cover(original, window));
    RELIEF_CHECK(check_cover(decoded, window));
    const LatticeBox box = spline::needed_box(window, original.rows, original.cols);
    const double scale =
        std::max(largest_magnitude(original, box), largest_magnitude(decoded, box));
    const std::int64_t tiles_across = (window.cols - 2) / kTileCols + 1;
    const std::int64_t tiles_down = (window.rows - 2) / kTileRows + 1;
    std::vector<double> bounds(static_cast<std::size_t>(tiles_across * tiles_down));
    for_tiles(window.rows - 1, window.cols - 1, [&](const LatticeBox& cells) {
        const LatticeBox vertices = {window.row0 + cells.row0, window.col0 + cells.col0,
                                     cells.rows + 1, cells.cols + 1};
        bounds[static_cast<std::size_t>(cells.row0 / kTileRows * tiles_across +
                                        cells.col0 / kTileCols)] =
            tile_bound(original, decoded, vertices, refinements);
    });
    double largest = 0;
    for (const double bound : bounds) raise(largest, bound);
    if (!std::isfinite(largest) || !std::isfinite(scale))
        return Error{ErrorCode::BadInput,
                     "a sample is not finite; fill holes before certifying a surface", "samples"};
    return largest + 1e-13 * scale;
}

template <class T>
Result<double> certify(GridView<const T> original, GridView<const T> decoded, int refinements) {
    return certify(RasterPart<T>::whole(original), RasterPart<T>::whole(decoded),
                   {0, 0, original.rows, original.cols}, refinements);
}

#define RELIEF_INSTANTIATE(T)                                                                      \
    template Result<Grid<T>> cell_bounds(const FvsGridView<const T>&, int);                        \
    template Result<double> certify(const RasterPart<T>&, const RasterPart<T>&, const LatticeBox&, \
                                    int);                                                          \
    template Result<double> certify(GridView<const T>, GridView<const T>, int);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::fvs
