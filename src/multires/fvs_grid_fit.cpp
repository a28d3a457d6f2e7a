#include "relief/multires/fvs_grid_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/core/rows.h"
#include "relief/multires/fvs_grid_transform.h"
#include "relief/spline/fvs_cell.h"

namespace relief::multires::fvs {

namespace {

using spline::kFvsCell;
using spline::kFvsCellNumbers;
using CellNumbers = std::array<double, kFvsCellNumbers>;

/// Keeps numbers that no sample determines where the start has them.
constexpr double kRidge = 1e-10;
constexpr double kTolerance = 1e-9;  ///< of the residual, in the preconditioned norm
constexpr int kMostIterations = 500;

FvsGrid<double> zeros_like(const FvsGrid<double>& grid) {
    FvsGrid<double> zero(grid.nx(), grid.ny());
    for (auto& plane : zero.planes) plane = Grid<double>(plane.rows(), plane.cols(), 0.0);
    return zero;
}

FvsGrid<double> copy_of(const FvsGrid<double>& grid) {
    FvsGrid<double> copy(grid.nx(), grid.ny(), grid.a, grid.b);
    for (std::size_t p = 0; p < spline::kFvsPlanes; ++p) copy.planes[p] = grid.planes[p].clone();
    return copy;
}

/// Runs run(plane, row) for all rows of nodal data.
template <class Run>
void for_rows(const FvsGrid<double>& grid, Run run) {
    for (int p = 0; p < spline::kFvsPlanes; ++p)
        parallel_for(0, grid[p].rows(), 64, [&](std::int64_t first, std::int64_t last) {
            for (std::int64_t r = first; r < last; ++r) run(p, r);
        });
}

/// Sum of u v, added in the order of rows whatever the threads.
double dot(const FvsGrid<double>& u, const FvsGrid<double>& v) {
    std::array<std::vector<double>, spline::kFvsPlanes> sums;
    for (std::size_t p = 0; p < spline::kFvsPlanes; ++p)
        sums[p].resize(static_cast<std::size_t>(u.planes[p].rows()));
    for_rows(u, [&](int p, std::int64_t r) {
        double sum = 0;
        for (std::int64_t c = 0; c < u[p].cols(); ++c) sum += u[p](r, c) * v[p](r, c);
        sums[static_cast<std::size_t>(p)][static_cast<std::size_t>(r)] = sum;
    });
    double total = 0;
    for (const auto& plane : sums)
        for (const double sum : plane) total += sum;
    return total;
}

/// to += factor * from.
void add(double factor, const FvsGrid<double>& from, FvsGrid<double>& to) {
    for_rows(from, [&](int p, std::int64_t r) {
        const RowTap<double> tap = {from[p].row(r), factor};
        row_fir_add(to[p].row(r), from[p].cols(), &tap, 1);
    });
}

/// direction = gradient + factor * direction.
void turn(const FvsGrid<double>& gradient, double factor, FvsGrid<double>& direction) {
    for_rows(gradient, [&](int p, std::int64_t r) {
        const RowTap<double> taps[] = {{gradient[p].row(r), 1}, {direction[p].row(r), factor}};
        row_fir(direction[p].row(r), gradient[p].cols(), taps, 2);
    });
}

CellNumbers numbers_of(const FvsGrid<double>& grid, std::int64_t row, std::int64_t col) {
    CellNumbers numbers{};
    for (std::size_t k = 0; k < kFvsCellNumbers; ++k)
        numbers[k] = grid[kFvsCell[k].plane](row + kFvsCell[k].row, col + kFvsCell[k].col);
    return numbers;
}

void add_numbers(const CellNumbers& numbers, std::int64_t row, std::int64_t col,
                 FvsGrid<double>& grid) {
    for (std::size_t k = 0; k < kFvsCellNumbers; ++k)
        grid[kFvsCell[k].plane](row + kFvsCell[k].row, col + kFvsCell[k].col) += numbers[k];
}

/// Least squares at the samples of a raster, by nodal data per cell of step x step samples.
template <class T>
class Samples {
  public:
    Samples(GridView<const T> values, GridView<const std::uint8_t> mask, int level)
        : values_(values),
          mask_(mask),
          step_(std::int64_t{1} << level),
          rows_(cells_of(values.rows)),
          cols_(cells_of(values.cols)),
          weights_(static_cast<std::size_t>((step_ + 1) * (step_ + 1))),
          whole_(static_cast<std::size_t>(rows_ * cols_)) {
        for (std::int64_t r = 0; r <= step_; ++r)
            for (std::int64_t c = 0; c <= step_; ++c)
                weights_[static_cast<std::size_t>(r * (step_ + 1) + c)] =
                    spline::fvs_value_weights(double(r) / double(step_), double(c) / double(step_));
        for (std::int64_t r = 0; r < rows_; ++r)
            for (std::int64_t c = 0; c < cols_; ++c)
                whole_[static_cast<std::size_t>(r * cols_ + c)] = is_whole(r, c);
        make_blocks();
    }

    [[nodiscard]] std::int64_t rows() const { return rows_; }
    [[nodiscard]] std::int64_t cols() const { return cols_; }

    /// out += (transpose of sampling) (sampling of x).
    void add_normal(const FvsGrid<double>& x, FvsGrid<double>& out) const {
        for_cells([&](std::int64_t r, std::int64_t c) {
            const CellNumbers numbers = numbers_of(x, r, c);
            CellNumbers sum{};
            if (whole(r, c)) {
                const auto& block = blocks_[block_of(r, c)];
                for (std::size_t k = 0; k < kFvsCellNumbers; ++k)
                    for (std::size_t n = 0; n < kFvsCellNumbers; ++n)
                        sum[n] += block[k][n] * numbers[k];
            } else {
                for_samples(r, c, [&](std::int64_t, std::int64_t, const CellNumbers& w) {
                    const double value = at(w, numbers);
                    for (std::size_t k = 0; k < kFvsCellNumbers; ++k) sum[k] += value * w[k];
                });
            }
            add_numbers(sum, r, c, out);
        });
    }

    /// out += (transpose of sampling) (values - sampling of x).
    void add_residual(const FvsGrid<double>& x, FvsGrid<double>& out) const {
        for_cells([&](std::int64_t r, std::int64_t c) {
            const CellNumbers numbers = numbers_of(x, r, c);
            CellNumbers sum{};
            for_samples(r, c, [&](std::int64_t row, std::int64_t col, const CellNumbers& w) {
                const double rest = static_cast<double>(values_(row, col)) - at(w, numbers);
                for (std::size_t k = 0; k < kFvsCellNumbers; ++k) sum[k] += rest * w[k];
            });
            add_numbers(sum, r, c, out);
        });
    }

    /// out += diagonal of the normal matrix.
    void add_diagonal(FvsGrid<double>& out) const {
        for_cells([&](std::int64_t r, std::int64_t c) {
            CellNumbers sum{};
            for_samples(r, c, [&](std::int64_t, std::int64_t, const CellNumbers& w) {
                for (std::size_t k = 0; k < kFvsCellNumbers; ++k) sum[k] += w[k] * w[k];
            });
            add_numbers(sum, r, c, out);
        });
    }

  private:
    using Block = std::array<CellNumbers, kFvsCellNumbers>;

    [[nodiscard]] std::int64_t cells_of(std::int64_t samples) const {
        return (samples - 2) / step_ + 1;
    }
    [[nodiscard]] bool whole(std::int64_t r, std::int64_t c) const {
        return whole_[static_cast<std::size_t>(r * cols_ + c)];
    }
    /// Samples on a line between cells belong to the later one, those of the last line to the last.
    [[nodiscard]] std::int64_t owned(std::int64_t cell, std::int64_t cells) const {
        return cell == cells - 1 ? step_ + 1 : step_;
    }
    [[nodiscard]] bool valid(std::int64_t row, std::int64_t col) const {
        return mask_.data == nullptr || mask_(row, col) != 0;
    }
    [[nodiscard]] bool is_whole(std::int64_t r, std::int64_t c) const {
        for (std::int64_t i = 0; i < owned(r, rows_); ++i)
            for (std::int64_t j = 0; j < owned(c, cols_); ++j) {
                const std::int64_t row = r * step_ + i, col = c * step_ + j;
                if (row >= values_.rows || col >= values_.cols || !valid(row, col)) return false;
            }
        return true;
    }
    [[nodiscard]] std::size_t block_of(std::int64_t r, std::int64_t c) const {
        return (r == rows_ - 1 ? 2U : 0U) + (c == cols_ - 1 ? 1U : 0U);
    }
    static double at(const CellNumbers& weights, const CellNumbers& numbers) {
        double sum = 0;
        for (std::size_t k = 0; k < kFvsCellNumbers; ++k) sum += weights[k] * numbers[k];
        return sum;
    }

    void make_blocks() {
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
            blocks_[b] = {};
            for (std::int64_t i = 0; i < step_ + (b & 2 ? 1 : 0); ++i)
                for (std::int64_t j = 0; j < step_ + (b & 1 ? 1 : 0); ++j) {
                    const CellNumbers& w = weights_[static_cast<std::size_t>(i * (step_ + 1) + j)];
                    for (std::size_t m = 0; m < kFvsCellNumbers; ++m)
                        for (std::size_t n = 0; n < kFvsCellNumbers; ++n)
                            blocks_[b][m][n] += w[m] * w[n];
                }
        }
    }

    /// Runs run(row, col, weights) for the valid samples that a cell owns.
    template <class Run>
    void for_samples(std::int64_t r, std::int64_t c, Run run) const {
        const std::int64_t rows = std::min(owned(r, rows_), values_.rows - r * step_);
        const std::int64_t cols = std::min(owned(c, cols_), values_.cols - c * step_);
        for (std::int64_t i = 0; i < rows; ++i)
            for (std::int64_t j = 0; j < cols; ++j)
                if (valid(r * step_ + i, c * step_ + j))
                    run(r * step_ + i, c * step_ + j,
                        weights_[static_cast<std::size_t>(i * (step_ + 1) + j)]);
    }

    /// Runs run(r, c) for all cells; those of one row after another, so that sums have one order,
    /// and of rows that share no number at the same time.
    template <class Run>
    void for_cells(Run run) const {
        for (std::int64_t parity = 0; parity < 2; ++parity)
            parallel_for(0, (rows_ + 1 - parity) / 2, 8,
                         [&](std::int64_t first, std::int64_t last) {
                             for (std::int64_t r = first; r < last; ++r)
                                 for (std::int64_t c = 0; c < cols_; ++c) run(2 * r + parity, c);
                         });
    }

    GridView<const T> values_;
    GridView<const std::uint8_t> mask_;
    std::int64_t step_;
    std::int64_t rows_;  ///< of cells
    std::int64_t cols_;
    std::vector<CellNumbers> weights_;  ///< of the samples of a cell
    std::vector<bool> whole_;           ///< cells without holes inside the raster
    std::array<Block, 4> blocks_;       ///< of whole cells; bits: last row, last column
};

/// x + the correction that solves the normal equations. Derivatives per cell.
template <class T>
void solve(const Samples<T>& samples, FvsGrid<double>& x) {
    FvsGrid<double> scale = zeros_like(x);
    samples.add_diagonal(scale);
    for_rows(scale, [&](int p, std::int64_t r) {
        for (std::int64_t c = 0; c < scale[p].cols(); ++c)
            scale[p](r, c) = 1 / (scale[p](r, c) + kRidge);
    });
    const auto preconditioned = [&](const FvsGrid<double>& residual) {
        FvsGrid<double> scaled = zeros_like(residual);
        for_rows(residual, [&](int p, std::int64_t r) {
            for (std::int64_t c = 0; c < residual[p].cols(); ++c)
                scaled[p](r, c) = scale[p](r, c) * residual[p](r, c);
        });
        return scaled;
    };
    FvsGrid<double> residual = zeros_like(x);
    samples.add_residual(x, residual);
    FvsGrid<double> gradient = preconditioned(residual);
    FvsGrid<double> direction = copy_of(gradient);
    double size = dot(residual, gradient);
    const double goal = kTolerance * kTolerance * size;
    for (int k = 0; k < kMostIterations && size > goal; ++k) {
        FvsGrid<double> image = zeros_like(x);
        samples.add_normal(direction, image);
        add(kRidge, direction, image);
        const double step = size / dot(direction, image);
        add(step, direction, x);
        add(-step, image, residual);
        gradient = preconditioned(residual);
        const double before = std::exchange(size, dot(residual, gradient));
        turn(gradient, size / before, direction);
    }
}

/// Derivatives per cell to derivatives per sample, or back.
void scale_derivatives(FvsGrid<double>& grid, double factor) {
    for_rows(grid, [&](int p, std::int64_t r) {
        for (std::int64_t c = 0; p != spline::kFvsF && c < grid[p].cols(); ++c)
            grid[p](r, c) *= factor;
    });
}

/// The data of every 2^level-th sample with derivatives estimated from all.
template <class T>
FvsGrid<double> hermite_start(GridView<const T> values, int level) {
    Grid<double> samples(values.rows, values.cols);
    for (std::int64_t r = 0; r < values.rows; ++r)
        std::copy_n(values.row(r), values.cols, samples.row(r));
    auto estimated = spline::estimate_fvs_grid(spline::RasterPart<double>::whole(samples.view()),
                                               {0, 0, values.rows, values.cols});
    FvsGrid<double> fine = *std::move(estimated);
    for (int l = 0; l < level; ++l) {
        FvsGrid<double> coarse(coarser(fine.nx()), coarser(fine.ny()), 2 * fine.a, 2 * fine.b);
        Details<double> details(fine.nx(), fine.ny());
        decompose(std::as_const(fine).view(), Lifting::None, coarse.view(), details.view());
        fine = std::move(coarse);
    }
    return fine;
}

template <class T>
double mean_of(GridView<const T> values, GridView<const std::uint8_t> mask) {
    double sum = 0;
    std::int64_t count = 0;
    for (std::int64_t r = 0; r < values.rows; ++r)
        for (std::int64_t c = 0; c < values.cols; ++c)
            if (mask.data == nullptr || mask(r, c) != 0) {
                sum += static_cast<double>(values(r, c));
                ++count;
            }
    return sum / static_cast<double>(count);
}

/// Fits from the coarsest level down, each started from the one before.
template <class T>
FvsGrid<double> fit_with_holes(GridView<const T> values, GridView<const std::uint8_t> mask,
                               int level) {
    int coarsest = level;
    while ((std::int64_t{1} << coarsest) < std::max(values.rows, values.cols) - 1) ++coarsest;
    FvsGrid<double> grid;
    for (int l = coarsest; l >= level; --l) {
        const Samples<T> samples(values, mask, l);
        const double size = std::ldexp(1.0, l);
        FvsGrid<double> finer(samples.cols(), samples.rows(), size, size);
        if (l == coarsest) {
            finer = zeros_like(finer);
            finer.a = finer.b = size;
            const double mean = mean_of(values, mask);
            finer[spline::kFvsF] = Grid<double>(finer.ny() + 1, finer.nx() + 1, mean);
        } else {
            predict(std::as_const(grid).view(), finer.view());
        }
        grid = std::move(finer);
        scale_derivatives(grid, size);
        solve(samples, grid);
        scale_derivatives(grid, 1 / size);
    }
    return grid;
}

template <class T>
Status check(GridView<const T> values, GridView<const std::uint8_t> mask, int level) {
    if (values.rows < 3 || values.cols < 3)
        return Error{ErrorCode::BadInput,
                     "a raster of " + std::to_string(values.rows) + " x " +
                         std::to_string(values.cols) +
                         " samples is too small for a fit; it needs at least 3 x 3",
                     "raster"};
    if (level < 1 || level > 30 ||
        (std::int64_t{1} << level) > std::min(values.rows, values.cols) - 1)
        return Error{ErrorCode::InvalidArgument,
                     "level " + std::to_string(level) +
                         " does not suit the raster; cells of 2^level samples must have at least 2 "
                         "and fit in it",
                     "level"};
    if (mask.data != nullptr && (mask.rows != values.rows || mask.cols != values.cols))
        return Error{ErrorCode::InvalidArgument, "the mask has not the size of the raster", "mask"};
    std::int64_t count = 0;
    for (std::int64_t r = 0; r < values.rows; ++r)
        for (std::int64_t c = 0; c < values.cols; ++c) {
            if (mask.data != nullptr && mask(r, c) == 0) continue;
            ++count;
            if (!std::isfinite(values(r, c)))
                return Error{ErrorCode::BadInput,
                             "sample (" + std::to_string(r) + ", " + std::to_string(c) +
                                 ") is not finite; mask holes",
                             "raster"};
        }
    if (count > 0) return {};
    return Error{ErrorCode::BadInput, "the raster has no valid sample", "mask"};
}

}  // namespace

template <class T>
Result<FvsGrid<double>> fit_fvs_grid(GridView<const T> values, GridView<const std::uint8_t> mask,
                                     int level) {
    RELIEF_CHECK(check(values, mask, level));
    for (std::int64_t r = 0; mask.data != nullptr && r < mask.rows; ++r)
        if (std::find(mask.row(r), mask.row(r) + mask.cols, 0) != mask.row(r) + mask.cols)
            return fit_with_holes(values, mask, level);
    FvsGrid<double> grid = hermite_start(values, level);
    const double size = std::ldexp(1.0, level);
    scale_derivatives(grid, size);
    solve(Samples<T>(values, mask, level), grid);
    scale_derivatives(grid, 1 / size);
    return grid;
}

template Result<FvsGrid<double>> fit_fvs_grid(GridView<const float>, GridView<const std::uint8_t>,
                                              int);
template Result<FvsGrid<double>> fit_fvs_grid(GridView<const double>, GridView<const std::uint8_t>,
                                              int);

}  // namespace relief::multires::fvs
