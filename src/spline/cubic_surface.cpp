#include "relief/spline/cubic_surface.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/core/rows.h"
#include "relief/spline/cubic_filters.h"
#include "spline/evaluation.h"
#include "spline/ringed_grid.h"

namespace relief::spline {

namespace {

constexpr std::int64_t kPointGrain = 4096;

/// Coefficients before and after a cell that reach into it.
constexpr int kBefore = 1;
constexpr int kAfter = 2;
constexpr int kReaching = 4;

/// The four B-splines that reach into a cell, or their derivatives, at one place.
template <class T>
using Weights = T[kReaching];

/// At the place t of a cell, 0 <= t <= 1.
template <class T>
void spline_weights(T t, Weights<T>& w) {
    const T u = 1 - t;
    w[0] = u * u * u * T(1.0 / 6);
    w[1] = (4 + t * t * (3 * t - 6)) * T(1.0 / 6);
    w[2] = (4 + u * u * (3 * u - 6)) * T(1.0 / 6);
    w[3] = t * t * t * T(1.0 / 6);
}

template <class T>
void slope_weights(T t, Weights<T>& w) {
    const T u = 1 - t;
    w[0] = u * u * T(-0.5);
    w[1] = t * (3 * t - 4) * T(0.5);
    w[2] = u * (4 - 3 * u) * T(0.5);
    w[3] = t * t * T(0.5);
}

template <class T>
void curvature_weights(T t, Weights<T>& w) {
    w[0] = 1 - t;
    w[1] = 3 * t - 2;
    w[2] = 1 - 3 * t;
    w[3] = t;
}

/// Sums in the order of row_fir, so that grids and points have the same bits.
template <class T>
T weighted(const Weights<T>& weights, const T* values) {
    T sum = weights[0] * values[0];
    for (int k = 1; k < kReaching; ++k) sum = sum + weights[k] * values[k];
    return sum;
}

/// The four sums down the columns of a cell's coefficients; `corner` is the first of them.
template <class T>
void down_columns(const Weights<T>& weights, const T* corner, std::int64_t stride,
                  Weights<T>& sums) {
    for (int c = 0; c < kReaching; ++c) sums[c] = weights[0] * corner[c];
    for (int r = 1; r < kReaching; ++r)
        for (int c = 0; c < kReaching; ++c) sums[c] = sums[c] + weights[r] * corner[r * stride + c];
}

}  // namespace

template <class T>
struct CubicSurface<T>::Data {
    explicit Data(const GridView<const T>& values)
        : grid(values.rows, values.cols, kBefore, kAfter) {
        (void)interpolate_cubic<T>(values, grid.box);  // sizes are right
        mirror_ring();
    }

    /// Whole-sample mirror; a box one wide continues as a constant.
    void mirror_ring() {
        const GridView<T>& box = grid.box;
        const auto mirrored = [](std::int64_t k, std::int64_t n) {
            while (n > 1 && (k < 0 || k >= n)) k = k < 0 ? -k : 2 * (n - 1) - k;
            return n > 1 ? k : 0;
        };
        for (std::int64_t r = 0; r < box.rows; ++r) {
            T* row = box.row(r);
            for (const std::int64_t c : {std::int64_t{-1}, box.cols, box.cols + 1})
                row[c] = row[mirrored(c, box.cols)];
        }
        for (const std::int64_t r : {std::int64_t{-1}, box.rows, box.rows + 1})
            std::copy_n(box.row(mirrored(r, box.rows)) - kBefore, box.cols + kBefore + kAfter,
                        box.row(r) - kBefore);
    }

    template <int kDerivatives>
    [[nodiscard]] SurfaceJet<T> jet(double i, double j) const {
        const Place<T> row(i, grid.box.rows - 1);
        const Place<T> col(j, grid.box.cols - 1);
        const T* corner = grid.box.row(row.cell - kBefore) + (col.cell - kBefore);
        const std::int64_t stride = grid.box.stride;
        Weights<T> down, along, sums;
        SurfaceJet<T> jet;
        spline_weights(row.fraction, down);
        spline_weights(col.fraction, along);
        down_columns(down, corner, stride, sums);
        jet.value = weighted(along, sums);
        if constexpr (kDerivatives >= 1) {
            Weights<T> slope_down, slope_along, slope_sums;
            slope_weights(row.fraction, slope_down);
            slope_weights(col.fraction, slope_along);
            down_columns(slope_down, corner, stride, slope_sums);
            jet.di = weighted(along, slope_sums);
            jet.dj = weighted(slope_along, sums);
            if constexpr (kDerivatives >= 2) {
                jet.dij = weighted(slope_along, slope_sums);
                Weights<T> curvature;
                curvature_weights(col.fraction, curvature);
                jet.djj = weighted(curvature, sums);
                curvature_weights(row.fraction, curvature);
                down_columns(curvature, corner, stride, sums);
                jet.dii = weighted(along, sums);
            }
        }
        return jet;
    }

    template <int kDerivatives>
    void evaluate(std::span<const T> i, std::span<const T> j, const JetSpans<T>& out) const {
        parallel_for(0, static_cast<std::int64_t>(i.size()), kPointGrain,
                     [&](std::int64_t first, std::int64_t last) {
                         for (auto k = static_cast<std::size_t>(first);
                              k < static_cast<std::size_t>(last); ++k) {
                             const SurfaceJet<T> at = jet<kDerivatives>(i[k], j[k]);
                             out.value[k] = at.value;
                             if constexpr (kDerivatives >= 1) {
                                 out.di[k] = at.di;
                                 out.dj[k] = at.dj;
                             }
                             if constexpr (kDerivatives >= 2) {
                                 out.dii[k] = at.dii;
                                 out.dij[k] = at.dij;
                                 out.djj[k] = at.djj;
                             }
                         }
                     });
    }

    RingedGrid<T> grid;
};

template <class T>
CubicSurface<T>::CubicSurface(std::unique_ptr<const Data> data) : data_(std::move(data)) {}
template <class T>
CubicSurface<T>::CubicSurface(CubicSurface&&) noexcept = default;
template <class T>
CubicSurface<T>& CubicSurface<T>::operator=(CubicSurface&&) noexcept = default;
template <class T>
CubicSurface<T>::~CubicSurface() = default;

template <class T>
Result<CubicSurface<T>> CubicSurface<T>::create(GridView<const T> values) {
    if (values.rows < 1 || values.cols < 1)
        return Error{ErrorCode::BadInput, "a surface needs at least one value", "values"};
    return CubicSurface(std::make_unique<const Data>(values));
}

template <class T>
std::int64_t CubicSurface<T>::rows() const {
    return data_->grid.box.rows;
}
template <class T>
std::int64_t CubicSurface<T>::cols() const {
    return data_->grid.box.cols;
}

template <class T>
bool CubicSurface<T>::contains(double i, double j) const {
    return i >= 0 && i <= static_cast<double>(rows() - 1) && j >= 0 &&
           j <= static_cast<double>(cols() - 1);
}

template <class T>
SurfaceJet<T> CubicSurface<T>::jet(double i, double j) const {
    return data_->template jet<2>(i, j);
}

template <class T>
Status CubicSurface<T>::evaluate(std::span<const T> i, std::span<const T> j, int derivatives,
                                 const JetSpans<T>& out) const {
    RELIEF_CHECK(check_spans(i.size(), j.size(), derivatives, out));
    switch (derivatives) {
        case 0:
            data_->template evaluate<0>(i, j, out);
            break;
        case 1:
            data_->template evaluate<1>(i, j, out);
            break;
        default:
            data_->template evaluate<2>(i, j, out);
    }
    return {};
}

template <class T>
void CubicSurface<T>::evaluate_grid(double i0, double di, double j0, double dj,
                                    GridView<T> out) const {
    if (out.count() == 0) return;
    struct Column {
        std::int64_t cell;
        Weights<T> weights;
    };
    std::vector<Column> columns(static_cast<std::size_t>(out.cols));
    for (std::int64_t c = 0; c < out.cols; ++c) {
        const Place<T> place(j0 + static_cast<double>(c) * dj, cols() - 1);
        Column& column = columns[static_cast<std::size_t>(c)];
        column.cell = place.cell;
        spline_weights(place.fraction, column.weights);
    }
    const std::int64_t first_cell = std::min(columns.front().cell, columns.back().cell);
    const std::int64_t last_cell = std::max(columns.front().cell, columns.back().cell);
    const std::int64_t width = last_cell - first_cell + kReaching;
    const std::int64_t grain = kPointGrain / out.cols + 1;
    parallel_for(0, out.rows, grain, [&](std::int64_t first, std::int64_t last) {
        std::vector<T> sums(static_cast<std::size_t>(width));
        for (std::int64_t r = first; r < last; ++r) {
            const Place<T> row(i0 + static_cast<double>(r) * di, rows() - 1);
            Weights<T> weights;
            spline_weights(row.fraction, weights);
            RowTap<T> taps[kReaching];
            for (int k = 0; k < kReaching; ++k)
                taps[k] = {data_->grid.box.row(row.cell - kBefore + k) + (first_cell - kBefore),
                           weights[k]};
            row_fir(sums.data(), width, taps, kReaching);
            for (std::int64_t c = 0; c < out.cols; ++c) {
                const Column& column = columns[static_cast<std::size_t>(c)];
                out(r, c) = weighted(column.weights, sums.data() + (column.cell - first_cell));
            }
        }
    });
}

template class CubicSurface<float>;
template class CubicSurface<double>;

}  // namespace relief::spline
