#include "relief/spline/box_surface.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "relief/core/parallel.h"
#include "spline/box_kernels.h"
#include "spline/evaluation.h"
#include "spline/ringed_grid.h"

namespace relief::spline {

namespace {

constexpr std::int64_t kBlock = 256;
constexpr std::int64_t kPointGrain = 16 * kBlock;

template <class T>
OrdinateSums<T> make_sums(int order) {
    const BoxSpline& spline = box_spline(order);
    OrdinateSums<T> sums;
    sums.scale = 1 / static_cast<double>(spline.denominator);
    for (int k = 0; k < ordinate_count(spline.degree); ++k) {
        for (int n = 0; n < static_cast<int>(spline.reach.size()); ++n) {
            const std::int64_t weight = spline.reach[n].numerators[k];
            if (weight != 0) sums.terms.push_back({static_cast<T>(weight), n});
        }
        sums.ends.push_back(static_cast<int>(sums.terms.size()));
    }
    return sums;
}

template <class T>
const OrdinateSums<T>& ordinate_sums(int order) {
    static const OrdinateSums<T> tables[] = {make_sums<T>(1), make_sums<T>(2), make_sums<T>(3),
                                             make_sums<T>(4)};
    return tables[order - 1];
}

}  // namespace

/// Columns first, first + 1, .. of a regular grid that lie in the domain; every `period` columns
/// their places in the cells repeat, `advance` cells farther. period = 0: they do not, or not soon
/// enough to be worth filtering.
struct RepeatingColumns {
    std::int64_t first = 0;
    std::int64_t last = 0;
    std::int64_t period = 0;
    std::int64_t advance = 0;
};

RepeatingColumns repeating_columns(double j0, double dj, std::int64_t count,
                                   std::int64_t last_col) {
    constexpr int kMaxPeriod = 32;
    constexpr double kMaxAdvance = 8;
    RepeatingColumns columns;
    const auto inside = [&](std::int64_t c) {
        const double j = j0 + static_cast<double>(c) * dj;
        return j >= 0 && j <= static_cast<double>(last_col);
    };
    while (columns.first < count && !inside(columns.first)) ++columns.first;
    columns.last = columns.first;
    while (columns.last < count && inside(columns.last)) ++columns.last;
    for (int period = 1; dj > 0 && period <= kMaxPeriod; ++period) {
        const double advance = period * dj;
        if (advance > kMaxAdvance) break;
        if (advance != std::floor(advance) || columns.last - columns.first < 8 * period) continue;
        columns.period = period;
        columns.advance = static_cast<std::int64_t>(advance);
        break;
    }
    return columns;
}

template <class T>
struct BoxSurface<T>::Data {
    Data(const GridView<const T>& coefficients, int surface_order)
        : order(surface_order), grid(coefficients.rows, coefficients.cols, order - 1, order) {
        copy_box(coefficients, 0, 0, grid.box);
        extend_ring(grid);
        const std::int64_t stride = grid.box.stride;
        constexpr std::int64_t kExact = std::int64_t{1} << std::numeric_limits<T>::digits;
        indexable = grid.storage.rows() * stride <= std::numeric_limits<CellIndex<T>>::max() &&
                    std::max(coefficients.rows, coefficients.cols) <= kExact;
        kernel.order = order;
        kernel.sums = &ordinate_sums<T>(order);
        kernel.corner = grid.storage.row(0);
        kernel.origin = static_cast<CellIndex<T>>(grid.box.data - kernel.corner);
        kernel.stride = static_cast<CellIndex<T>>(stride);
        kernel.last_row = static_cast<T>(coefficients.rows - 1);
        kernel.last_col = static_cast<T>(coefficients.cols - 1);
        for (const ReachingControl& control : box_spline(order).reach) {
            const int k = kernel.offsets.count++;
            kernel.offsets.lower[k] = static_cast<CellIndex<T>>(control.i * stride + control.j);
            kernel.offsets.upper[k] = static_cast<CellIndex<T>>(control.j * stride + control.i);
        }
    }

    [[nodiscard]] SurfaceJet<T> jet(double i, double j) const {
        const Place<T> row(i, grid.box.rows - 1);
        const Place<T> col(j, grid.box.cols - 1);
        return jet_at(kernel, grid.box.row(row.cell) + col.cell, row.fraction, col.fraction);
    }

    void evaluate_block(const T* i, const T* j, std::int64_t count, const JetRows<T>& out) const {
        CellIndex<T> cell[kBlock];
        T fi[kBlock];
        T fj[kBlock];
        locate_points(kernel, count, i, j, cell, fi, fj);
        jets_at(kernel, {count, cell, fi, fj}, out);
    }

    void evaluate_columns(const Place<T>& row, const std::vector<Place<T>>& cols,
                          std::int64_t first, std::int64_t last, T* out) const;
    void filter_columns(const Place<T>& row, const std::vector<Place<T>>& cols,
                        const RepeatingColumns& columns, std::vector<T>& scratch, T* out) const;

    int order;
    RingedGrid<T> grid;
    bool indexable = true;  ///< CellIndex counts all elements, and T all rows and columns
    KernelSurface<T> kernel;
};

/// out[c] = value at (row, cols[c]) for first <= c < last.
template <class T>
void BoxSurface<T>::Data::evaluate_columns(const Place<T>& row, const std::vector<Place<T>>& cols,
                                           std::int64_t first, std::int64_t last, T* out) const {
    if (!indexable) {
        for (std::int64_t c = first; c < last; ++c)
            out[c] = jet_at(kernel, grid.box.row(row.cell) + cols[c].cell, row.fraction,
                            cols[c].fraction)
                         .value;
        return;
    }
    CellIndex<T> cell[kBlock];
    T fi[kBlock];
    T fj[kBlock];
    std::fill_n(fi, kBlock, row.fraction);
    const auto row_cell = static_cast<CellIndex<T>>(grid.box.row(row.cell) - kernel.corner);
    for (std::int64_t begin = first; begin < last; begin += kBlock) {
        const std::int64_t count = std::min(kBlock, last - begin);
        for (std::int64_t k = 0; k < count; ++k) {
            cell[k] = row_cell + static_cast<CellIndex<T>>(cols[begin + k].cell);
            fj[k] = cols[begin + k].fraction;
        }
        JetRows<T> value;
        value.value = out + begin;
        jets_at(kernel, {count, cell, fi, fj}, value);
    }
}

/// out[c] = value at (row, cols[c]) for the repeating columns: one filter over the row of cells a
/// phase.
template <class T>
void BoxSurface<T>::Data::filter_columns(const Place<T>& row, const std::vector<Place<T>>& cols,
                                         const RepeatingColumns& columns, std::vector<T>& scratch,
                                         T* out) const {
    for (std::int64_t phase = columns.first; phase < columns.first + columns.period; ++phase) {
        const Place<T>& col = cols[phase];
        double weights[WindowOffsets<T>::kMaxControls];
        window_weights(kernel, row.fraction, col.fraction, weights);
        const CellIndex<T>* offsets = kernel.window(row.fraction, col.fraction);
        RowTap<T> taps[WindowOffsets<T>::kMaxControls];
        int count = 0;
        for (int k = 0; k < kernel.offsets.count; ++k)
            if (weights[k] != 0)
                taps[count++] = {grid.box.row(row.cell) + col.cell + offsets[k],
                                 static_cast<T>(weights[k])};
        const std::int64_t points = (columns.last - phase + columns.period - 1) / columns.period;
        const std::int64_t cells = (points - 1) * columns.advance + 1;
        T* target = columns.period == 1 && columns.advance == 1 ? out + phase : scratch.data();
        row_fir(target, cells, taps, count);
        if (target != scratch.data()) continue;
        for (std::int64_t k = 0; k < points; ++k)
            out[phase + k * columns.period] = scratch[k * columns.advance];
    }
}

template <class T>
BoxSurface<T>::BoxSurface(std::unique_ptr<const Data> data) : data_(std::move(data)) {}
template <class T>
BoxSurface<T>::BoxSurface(BoxSurface&&) noexcept = default;
template <class T>
BoxSurface<T>& BoxSurface<T>::operator=(BoxSurface&&) noexcept = default;
template <class T>
BoxSurface<T>::~BoxSurface() = default;

template <class T>
Result<BoxSurface<T>> BoxSurface<T>::create(GridView<const T> coefficients, int order) {
    if (!valid_order(order))
        return Error{ErrorCode::InvalidArgument,
                     "box splines have orders 1 to 4, not " + std::to_string(order), "order"};
    if (coefficients.rows < 1 || coefficients.cols < 1)
        return Error{ErrorCode::BadInput, "a surface needs at least one coefficient",
                     "coefficients"};
    return BoxSurface(std::make_unique<const Data>(coefficients, order));
}

template <class T>
int BoxSurface<T>::order() const {
    return data_->order;
}
template <class T>
std::int64_t BoxSurface<T>::rows() const {
    return data_->grid.box.rows;
}
template <class T>
std::int64_t BoxSurface<T>::cols() const {
    return data_->grid.box.cols;
}

template <class T>
bool BoxSurface<T>::contains(double i, double j) const {
    return i >= 0 && i <= static_cast<double>(rows() - 1) && j >= 0 &&
           j <= static_cast<double>(cols() - 1);
}

template <class T>
SurfaceJet<T> BoxSurface<T>::jet(double i, double j) const {
    return data_->jet(i, j);
}

template <class T>
Status BoxSurface<T>::evaluate(std::span<const T> i, std::span<const T> j, int derivatives,
                               const JetSpans<T>& out) const {
    const std::size_t count = i.size();
    RELIEF_CHECK(check_spans(count, j.size(), derivatives, out));
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
                         store_jet(data_->jet(i[k], j[k]), rows_from(k));
                 });
    return {};
}

template <class T>
void BoxSurface<T>::evaluate_grid(double i0, double di, double j0, double dj,
                                  GridView<T> out) const {
    std::vector<Place<T>> places;
    for (std::int64_t c = 0; c < out.cols; ++c)
        places.emplace_back(j0 + static_cast<double>(c) * dj, cols() - 1);
    const RepeatingColumns columns = repeating_columns(j0, dj, out.cols, cols() - 1);
    const std::int64_t grain = kPointGrain / std::max<std::int64_t>(out.cols, 1) + 1;
    parallel_for(0, out.rows, grain, [&](std::int64_t first, std::int64_t last) {
        std::vector<T> scratch(columns.period ? cols() : 0);
        for (std::int64_t r = first; r < last; ++r) {
            const Place<T> row(i0 + static_cast<double>(r) * di, rows() - 1);
            if (columns.period == 0) {
                data_->evaluate_columns(row, places, 0, out.cols, out.row(r));
                continue;
            }
            data_->evaluate_columns(row, places, 0, columns.first, out.row(r));
            data_->filter_columns(row, places, columns, scratch, out.row(r));
            data_->evaluate_columns(row, places, columns.last, out.cols, out.row(r));
        }
    });
}

template class BoxSurface<float>;
template class BoxSurface<double>;

}  // namespace relief::spline
