#include "relief/spline/fvs_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/core/rows.h"
#include "spline/fvs_estimate.h"
#include "spline/fvs_kernels.h"

namespace relief::spline {

namespace {

constexpr std::int64_t kBlock = 256;
constexpr std::int64_t kPointGrain = 16 * kBlock;

/// A coordinate moved into [first, last], as cell and place in it; NaN counts as first.
template <class T>
struct Place {
    Place(double x, std::int64_t first, std::int64_t last) {
        const double low = static_cast<double>(first);
        const double inside = x > low ? std::min(x, static_cast<double>(last)) : low;
        cell = static_cast<std::int64_t>(inside);
        fraction = static_cast<T>(inside - static_cast<double>(cell));
    }
    /// The same point as the end of cell `last` if it lies in none.
    [[nodiscard]] Place inside(std::int64_t last) const {
        Place place = *this;
        if (cell > last) {
            place.cell = last;
            place.fraction = 1;
        }
        return place;
    }
    std::int64_t cell;
    T fraction;
};

/// Columns first .. last - 1 of a regular grid lie in the domain; every `period` columns their
/// places in the cells repeat, `advance` cells farther. period = 0: they do not, or not soon.
struct Columns {
    std::int64_t first = 0;
    std::int64_t last = 0;
    std::int64_t period = 0;
    std::int64_t advance = 0;
};

Columns columns_of(double j0, double dj, std::int64_t count, std::int64_t first_col,
                   std::int64_t last_col) {
    constexpr int kMaxPeriod = 32;
    constexpr double kMaxAdvance = 8;
    Columns columns;
    const auto inside = [&](std::int64_t c) {
        const double j = j0 + static_cast<double>(c) * dj;
        return j >= static_cast<double>(first_col) && j <= static_cast<double>(last_col);
    };
    while (columns.first < count && !inside(columns.first)) ++columns.first;
    columns.last = columns.first;
    while (columns.last < count && inside(columns.last)) ++columns.last;
    for (int period = 1; dj > 0 && period <= kMaxPeriod && period * dj <= kMaxAdvance; ++period) {
        const double advance = period * dj;
        if (advance != std::floor(advance)) continue;
        columns.period = period;
        columns.advance = static_cast<std::int64_t>(advance);
        break;
    }
    return columns;
}

/// Points x0, x0 + dx, .., x0 + (count - 1) dx.
struct RegularPoints {
    double x0;
    double dx;
    std::int64_t first;
    std::int64_t last;

    [[nodiscard]] double operator[](std::int64_t k) const {
        return x0 + static_cast<double>(k) * dx;
    }
    /// The lattice lines first .. last between which they lie, moved into 0 .. n - 1.
    [[nodiscard]] std::pair<std::int64_t, std::int64_t> lines(std::int64_t n) const {
        const Place<double> begin((*this)[first], 0, n - 1);
        const Place<double> end((*this)[last - 1], 0, n - 1);
        const Place<double>& low = dx < 0 ? end : begin;
        const Place<double>& high = dx < 0 ? begin : end;
        return {low.cell, high.cell + (high.fraction > 0 ? 1 : 0)};
    }
};

LatticeBox window_of(const RegularPoints& i, const RegularPoints& j, std::int64_t raster_rows,
                     std::int64_t raster_cols) {
    const auto [top, bottom] = i.lines(raster_rows);
    const auto [left, right] = j.lines(raster_cols);
    return {top, left, bottom - top + 1, right - left + 1};
}

/// The vertices of the cells in which the points of a window lie: points on its last line lie in
/// the cells that begin there, except at the end of the raster.
LatticeBox with_cells(const LatticeBox& window, std::int64_t rows, std::int64_t cols) {
    const std::int64_t top = std::min(window.row0, rows - 2);
    const std::int64_t left = std::min(window.col0, cols - 2);
    const std::int64_t bottom = std::min(window.row0 + window.rows, rows - 1);
    const std::int64_t right = std::min(window.col0 + window.cols, cols - 1);
    return {top, left, bottom - top + 1, right - left + 1};
}

Status check_raster(std::int64_t rows, std::int64_t cols) {
    if (rows >= 2 && cols >= 2) return {};
    return Error{ErrorCode::BadInput,
                 "a raster of " + std::to_string(rows) + " x " + std::to_string(cols) +
                     " samples has no cell; a surface needs at least 2 x 2",
                 "raster"};
}

template <class T>
void scale(Grid<T>& plane, double factor) {
    if (factor == 1) return;
    for (std::int64_t r = 0; r < plane.rows(); ++r)
        for (std::int64_t c = 0; c < plane.cols(); ++c) plane(r, c) *= static_cast<T>(factor);
}

}  // namespace

template <class T>
struct FvsSurface<T>::Data {
    /// Vertex (0, 0) of `nodal` stands at (first_row, first_col).
    Data(FvsGrid<T> nodal, std::int64_t first_row, std::int64_t first_col, const LatticeBox& domain)
        : grid(std::move(nodal)),
          box(domain),
          row0(first_row),
          col0(first_col),
          end_row(row0 + grid.ny() - 1),
          end_col(col0 + grid.nx() - 1) {
        scale(grid[kFvsFx], grid.a);
        scale(grid[kFvsGv], grid.a);
        scale(grid[kFvsFy], grid.b);
        scale(grid[kFvsGh], grid.b);
        view = std::as_const(grid).view();
        constexpr std::int64_t kExact = std::int64_t{1} << std::numeric_limits<T>::digits;
        indexable =
            (grid.ny() + 1) * view[kFvsF].stride <= std::numeric_limits<CellIndex<T>>::max() &&
            std::max(end_row, end_col) + 1 < std::min<std::int64_t>(kExact, INT32_MAX);
        if (!indexable) return;
        for (std::size_t p = 0; p < kFvsPlanes; ++p) {
            kernel.plane[p] = view.planes[p].data;
            kernel.stride[p] = static_cast<CellIndex<T>>(view.planes[p].stride);
        }
        kernel.first_row = static_cast<T>(box.row0);
        kernel.last_row = static_cast<T>(box.row0 + box.rows - 1);
        kernel.first_col = static_cast<T>(box.col0);
        kernel.last_col = static_cast<T>(box.col0 + box.cols - 1);
        kernel.row0 = static_cast<CellIndex<T>>(row0);
        kernel.col0 = static_cast<CellIndex<T>>(col0);
        kernel.end_row = static_cast<CellIndex<T>>(end_row);
        kernel.end_col = static_cast<CellIndex<T>>(end_col);
    }

    [[nodiscard]] Place<T> row_place(double i) const {
        return {i, box.row0, box.row0 + box.rows - 1};
    }
    [[nodiscard]] Place<T> col_place(double j) const {
        return {j, box.col0, box.col0 + box.cols - 1};
    }
    [[nodiscard]] SurfaceJet<T> jet(const Place<T>& i, const Place<T>& j) const {
        const Place<T> row = i.inside(end_row);
        const Place<T> col = j.inside(end_col);
        return fvs_jet_at(view, row.cell - row0, col.cell - col0, row.fraction, col.fraction);
    }

    void evaluate_block(const T* i, const T* j, std::int64_t count, const JetRows<T>& out) const {
        CellIndex<T> row[kBlock], col[kBlock];
        T fi[kBlock], fj[kBlock];
        locate_fvs_points(kernel, count, i, j, row, col, fi, fj);
        fvs_jets_at(kernel, {count, row, col, fi, fj}, out);
    }

    void evaluate_columns(const Place<T>& row, const std::vector<Place<T>>& cols,
                          std::int64_t first, std::int64_t last, T* out) const;
    void filter_columns(const Place<T>& row, const std::vector<Place<T>>& cols,
                        const Columns& columns, std::vector<T>& scratch, T* out) const;
    /// Rows first .. last - 1 of evaluate_grid.
    void evaluate_rows(double i0, double di, double j0, double dj, std::int64_t first,
                       std::int64_t last, GridView<T> out) const;

    FvsGrid<T> grid;  ///< derivatives per cell
    LatticeBox box;
    std::int64_t row0;  ///< first and last cells
    std::int64_t col0;
    std::int64_t end_row;
    std::int64_t end_col;
    FvsGridView<const T> view;
    bool indexable = true;  ///< CellIndex counts all elements, and T all rows and columns
    FvsKernel<T> kernel;
};

/// out[c] = value at (row, cols[c]) for first <= c < last.
template <class T>
void FvsSurface<T>::Data::evaluate_columns(const Place<T>& row, const std::vector<Place<T>>& cols,
                                           std::int64_t first, std::int64_t last, T* out) const {
    if (!indexable) {
        for (std::int64_t c = first; c < last; ++c) out[c] = jet(row, cols[c]).value;
        return;
    }
    const Place<T> inner = row.inside(end_row);
    CellIndex<T> rows[kBlock], cells[kBlock];
    T fi[kBlock], fj[kBlock];
    std::fill_n(rows, kBlock, static_cast<CellIndex<T>>(inner.cell - row0));
    std::fill_n(fi, kBlock, inner.fraction);
    for (std::int64_t begin = first; begin < last; begin += kBlock) {
        const std::int64_t count = std::min(kBlock, last - begin);
        for (std::int64_t k = 0; k < count; ++k) {
            const Place<T> col = cols[begin + k].inside(end_col);
            cells[k] = static_cast<CellIndex<T>>(col.cell - col0);
            fj[k] = col.fraction;
        }
        JetRows<T> value;
        value.value = out + begin;
        fvs_jets_at(kernel, {count, rows, cells, fi, fj}, value);
    }
}

/// out[c] = value at (row, cols[c]) for the repeating columns: one filter over the row of cells a
/// phase.
template <class T>
void FvsSurface<T>::Data::filter_columns(const Place<T>& row, const std::vector<Place<T>>& cols,
                                         const Columns& columns, std::vector<T>& scratch,
                                         T* out) const {
    const std::int64_t phases = std::min(columns.period, columns.last - columns.first);
    for (std::int64_t phase = columns.first; phase < columns.first + phases; ++phase) {
        const Place<T>& col = cols[phase];
        const auto weights = fvs_value_weights(row.fraction, col.fraction);
        RowTap<T> taps[kFvsCellNumbers];
        int count = 0;
        for (std::size_t k = 0; k < kFvsCellNumbers; ++k) {
            const FvsCellNumber& number = kFvsCell[k];
            if (weights[k] != 0)
                taps[count++] = {view[number.plane].row(row.cell - row0 + number.row) +
                                     (col.cell - col0 + number.col),
                                 static_cast<T>(weights[k])};
        }
        const std::int64_t points = (columns.last - phase + columns.period - 1) / columns.period;
        row_fir(scratch.data(), (points - 1) * columns.advance + 1, taps, count);
        for (std::int64_t k = 0; k < points; ++k)
            out[phase + k * columns.period] = scratch[k * columns.advance];
    }
}

template <class T>
void FvsSurface<T>::Data::evaluate_rows(double i0, double di, double j0, double dj,
                                        std::int64_t first, std::int64_t last,
                                        GridView<T> out) const {
    std::vector<Place<T>> places;
    for (std::int64_t c = 0; c < out.cols; ++c)
        places.push_back(col_place(j0 + static_cast<double>(c) * dj));
    const Columns columns = columns_of(j0, dj, out.cols, box.col0, box.col0 + box.cols - 1);
    std::vector<T> scratch(columns.period ? static_cast<std::size_t>(box.cols) : 0);
    for (std::int64_t r = first; r < last; ++r) {
        const Place<T> row = row_place(i0 + static_cast<double>(r) * di);
        if (columns.period == 0) {
            evaluate_columns(row, places, 0, out.cols, out.row(r));
            continue;
        }
        evaluate_columns(row, places, 0, columns.first, out.row(r));
        filter_columns(row, places, columns, scratch, out.row(r));
        evaluate_columns(row, places, columns.last, out.cols, out.row(r));
    }
}

template <class T>
FvsSurface<T>::FvsSurface(std::unique_ptr<const Data> data) : data_(std::move(data)) {}
template <class T>
FvsSurface<T>::FvsSurface(FvsSurface&&) noexcept = default;
template <class T>
FvsSurface<T>& FvsSurface<T>::operator=(FvsSurface&&) noexcept = default;
template <class T>
FvsSurface<T>::~FvsSurface() = default;

template <class T>
Result<FvsSurface<T>> FvsSurface<T>::create(FvsGrid<T> grid, std::int64_t row0, std::int64_t col0) {
    RELIEF_CHECK(check_raster(grid.ny() + 1, grid.nx() + 1));
    if (row0 < 0 || col0 < 0)
        return Error{ErrorCode::InvalidArgument, "the origin of a surface must not be negative",
                     "origin"};
    const LatticeBox box = {row0, col0, grid.ny() + 1, grid.nx() + 1};
    return FvsSurface(std::make_unique<const Data>(std::move(grid), row0, col0, box));
}

template <class T>
Result<FvsSurface<T>> FvsSurface<T>::create(const RasterPart<T>& part, const LatticeBox& window) {
    RELIEF_CHECK(check_raster(part.rows, part.cols));
    RELIEF_CHECK(check_fvs_window(part, window));
    const LatticeBox vertices = with_cells(window, part.rows, part.cols);
    RELIEF_TRY(FvsGrid<T> grid, estimate_fvs_grid(part, vertices));
    return FvsSurface(
        std::make_unique<const Data>(std::move(grid), vertices.row0, vertices.col0, window));
}

template <class T>
LatticeBox FvsSurface<T>::samples_for(const LatticeBox& window, std::int64_t rows,
                                      std::int64_t cols) {
    return needed_box(with_cells(window, rows, cols), rows, cols);
}

template <class T>
LatticeBox FvsSurface<T>::box() const {
    return data_->box;
}

template <class T>
bool FvsSurface<T>::contains(double i, double j) const {
    const LatticeBox& box = data_->box;
    return i >= static_cast<double>(box.row0) &&
           i <= static_cast<double>(box.row0 + box.rows - 1) &&
           j >= static_cast<double>(box.col0) && j <= static_cast<double>(box.col0 + box.cols - 1);
}

template <class T>
SurfaceJet<T> FvsSurface<T>::jet(double i, double j) const {
    return data_->jet(data_->row_place(i), data_->col_place(j));
}

template <class T>
Status FvsSurface<T>::evaluate(std::span<const T> i, std::span<const T> j, int derivatives,
                               const JetSpans<T>& out) const {
    if (derivatives < 0 || derivatives > 2)
        return Error{ErrorCode::InvalidArgument,
                     "derivatives must be 0, 1 or 2, not " + std::to_string(derivatives),
                     "evaluate"};
    const std::size_t count = i.size();
    const bool sizes = j.size() == count && out.value.size() == count &&
                       (derivatives < 1 || (out.di.size() == count && out.dj.size() == count)) &&
                       (derivatives < 2 || (out.dii.size() == count && out.dij.size() == count &&
                                            out.djj.size() == count));
    if (!sizes)
        return Error{ErrorCode::InvalidArgument,
                     "all spans must have the size of the points, " + std::to_string(count),
                     "evaluate"};
    const auto rows_from = [&](std::int64_t k) {
        const auto from = [k](std::span<T> span) {
            return span.empty() ? nullptr : span.data() + k;
        };
        return JetRows<T>{derivatives,   from(out.value), from(out.di), from(out.dj),
                          from(out.dii), from(out.dij),   from(out.djj)};
    };
    parallel_for(0, static_cast<std::int64_t>(count), kPointGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (std::int64_t k = first; data_->indexable && k < last; k += kBlock)
                         data_->evaluate_block(i.data() + k, j.data() + k,
                                               std::min(kBlock, last - k), rows_from(k));
                     for (std::int64_t k = first; !data_->indexable && k < last; ++k)
                         store_jet(jet(i[k], j[k]), rows_from(k));
                 });
    return {};
}

template <class T>
void FvsSurface<T>::evaluate_grid(double i0, double di, double j0, double dj,
                                  GridView<T> out) const {
    const std::int64_t grain = kPointGrain / std::max<std::int64_t>(out.cols, 1) + 1;
    parallel_for(0, out.rows, grain, [&](std::int64_t first, std::int64_t last) {
        data_->evaluate_rows(i0, di, j0, dj, first, last, out);
    });
}

template <class T>
Status FvsSurface<T>::resample(const RasterPart<T>& part, double i0, double di, double j0,
                               double dj, GridView<T> out) {
    RELIEF_CHECK(check_raster(part.rows, part.cols));
    if (out.count() == 0) return {};
    const RegularPoints cols{j0, dj, 0, out.cols};
    const LatticeBox all = window_of({i0, di, 0, out.rows}, cols, part.rows, part.cols);
    RELIEF_CHECK(check_fvs_window(part, with_cells(all, part.rows, part.cols)));
    // Bands of about 32 rows of cells: their nodal data stay in the cache.
    const double cells = std::min(std::abs(di), 64.0) * static_cast<double>(out.rows);
    const auto bands = std::max<std::int64_t>(1, static_cast<std::int64_t>(cells / 32));
    const std::int64_t grain = (out.rows + bands - 1) / bands;
    parallel_for(0, out.rows, grain, [&](std::int64_t first, std::int64_t last) {
        const LatticeBox window = window_of({i0, di, first, last}, cols, part.rows, part.cols);
        const LatticeBox vertices = with_cells(window, part.rows, part.cols);
        FvsGrid<T> grid(vertices.cols - 1, vertices.rows - 1);
        estimate_fvs_rows(part, vertices, 0, vertices.rows, grid.view());
        const Data band(std::move(grid), vertices.row0, vertices.col0, window);
        band.evaluate_rows(i0, di, j0, dj, first, last, out);
    });
    return {};
}

template class FvsSurface<float>;
template class FvsSurface<double>;

LatticeBox resampling_box(double i0, double di, std::int64_t rows, double j0, double dj,
                          std::int64_t cols, std::int64_t raster_rows, std::int64_t raster_cols) {
    const LatticeBox window =
        window_of({i0, di, 0, rows}, {j0, dj, 0, cols}, raster_rows, raster_cols);
    return FvsSurface<double>::samples_for(window, raster_rows, raster_cols);
}

}  // namespace relief::spline
