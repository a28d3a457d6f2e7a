#include "relief/spline/lattice_filters.h"

#include <cmath>
#include <string>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/core/rows.h"
#include "spline/ringed_grid.h"

namespace relief::spline {

namespace {

constexpr std::int64_t kRowGrain = 64;

std::string size_text(std::int64_t rows, std::int64_t cols) {
    return std::to_string(rows) + " x " + std::to_string(cols);
}

template <class T>
Status check(int order, const GridView<const T>& in, const GridView<T>& out) {
    if (!valid_order(order))
        return Error{ErrorCode::InvalidArgument,
                     "box splines have orders 1 to 4, not " + std::to_string(order), "order"};
    if (in.rows < 1 || in.cols < 1)
        return Error{ErrorCode::BadInput, "the grid is empty; at least one value is needed",
                     size_text(in.rows, in.cols)};
    if (in.rows != out.rows || in.cols != out.cols)
        return Error{ErrorCode::InvalidArgument,
                     "the output must have the size of the input, " + size_text(in.rows, in.cols),
                     "output of " + size_text(out.rows, out.cols)};
    return {};
}

template <class T>
void copy_rows(const GridView<const T>& in, const GridView<T>& out) {
    parallel_for(0, in.rows, kRowGrain, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r) std::copy_n(in.row(r), in.cols, out.row(r));
    });
}

/// Enough for the largest mask, the Gram mask of order 4 with 169 taps, and one row more.
constexpr int kMaxTaps = 170;

/// Appends the taps of weight * in(r + i, c + j); all of them must be readable. Returns their end.
template <class T>
RowTap<T>* mask_taps(const std::vector<MaskTap>& mask, const GridView<T>& in, std::int64_t r,
                     RowTap<T>* taps) {
    for (const MaskTap& tap : mask)
        *taps++ = {in.row(r + tap.i) + tap.j, static_cast<T>(tap.weight)};
    return taps;
}

/// out[c] = sum of weight * in(r + i, c + j).
template <class T>
void correlate_row(const std::vector<MaskTap>& mask, const GridView<T>& in, std::int64_t r, T* out,
                   std::int64_t cols) {
    RowTap<T> taps[kMaxTaps];
    const auto count = mask_taps(mask, in, r, taps) - taps;
    row_fir(out, cols, taps, static_cast<int>(count));
}

/// Rows first .. last - 1 of `in` in the middle of a grid whose ring and remaining rows are zero.
template <class T>
RingedGrid<T> zero_extended(const GridView<const T>& in, std::int64_t first, std::int64_t last,
                            int ring) {
    RingedGrid<T> grid(last - first, in.cols, ring, ring);
    std::fill_n(grid.storage.row(0), grid.storage.rows() * grid.storage.stride(), T(0));
    const std::int64_t begin = std::max<std::int64_t>(first - ring, 0);
    const std::int64_t end = std::min(last + ring, in.rows);
    for (std::int64_t r = begin; r < end; ++r)
        std::copy_n(in.row(r), in.cols, grid.box.row(r - first));
    return grid;
}

/// A tile of the box with a margin of lattice points around it, cut at the box.
struct Tile {
    LatticeBox core;
    LatticeBox grown;
};

/// Cuts a box into tiles that stay, with their temporaries, in the second level cache. Grown tiles
/// are as wide as the blocks of row_fir ask for.
class Tiling {
  public:
    Tiling(std::int64_t rows, std::int64_t cols, std::int64_t margin)
        : rows_(rows),
          cols_(cols),
          margin_(margin),
          height_(kGrownRows - 2 * margin),
          width_(kGrownCols - 2 * margin),
          across_((cols + width_ - 1) / width_) {}

    [[nodiscard]] std::int64_t count() const { return (rows_ + height_ - 1) / height_ * across_; }
    [[nodiscard]] Tile operator[](std::int64_t k) const {
        const std::int64_t row0 = k / across_ * height_;
        const std::int64_t col0 = k % across_ * width_;
        const std::int64_t row1 = std::min(row0 + height_, rows_);
        const std::int64_t col1 = std::min(col0 + width_, cols_);
        const std::int64_t top = std::max<std::int64_t>(row0 - margin_, 0);
        const std::int64_t left = std::max<std::int64_t>(col0 - margin_, 0);
        const std::int64_t bottom = std::min(row1 + margin_, rows_);
        const std::int64_t right = std::min(col1 + margin_, cols_);
        return {{row0, col0, row1 - row0, col1 - col0}, {top, left, bottom - top, right - left}};
    }

  private:
    static constexpr std::int64_t kGrownRows = 128;
    static constexpr std::int64_t kGrownCols = 512;
    std::int64_t rows_;
    std::int64_t cols_;
    std::int64_t margin_;
    std::int64_t height_;
    std::int64_t width_;
    std::int64_t across_;
};

/// out(r) = base(r) + sum of weight * in(r + i, c + j) over all rows of `out`.
template <class T>
void add_correlation(const GridView<T>& base, T base_weight, const std::vector<MaskTap>& mask,
                     const GridView<T>& in, const GridView<T>& out) {
    RowTap<T> taps[kMaxTaps];
    for (std::int64_t r = 0; r < out.rows; ++r) {
        taps[0] = {base.row(r), base_weight};
        const auto count = mask_taps(mask, in, r, taps + 1) - taps;
        row_fir(out.row(r), out.cols, taps, static_cast<int>(count));
    }
}

/// identity - step * mask.
std::vector<MaskTap> relaxation_mask(std::vector<MaskTap> mask, double identity, double step) {
    for (MaskTap& tap : mask)
        tap.weight = (tap.i == 0 && tap.j == 0 ? identity : 0) - step * tap.weight;
    return mask;
}

/// out = start + e, where e comes from zero by the relaxations e <- e + step (residual - B e) of
/// the residual samples - B start. `start` without data is zero. Working on the residual keeps
/// rounding errors relative to e. Each tile is relaxed with a margin that it loses (order - 1
/// points an application of B) to the extension at its cut edges, so tiles agree to the bit with
/// the whole box.
template <class T>
void relax(int order, const GridView<const T>& samples, const GridView<const T>& start,
           const std::vector<double>& steps, const GridView<T>& out) {
    const std::vector<MaskTap>& mask = box_spline(order).samples;
    const std::vector<MaskTap> minus_mask = relaxation_mask(mask, 0, 1);
    const int ring = order - 1;
    const Tiling tiles(samples.rows, samples.cols, ring * static_cast<std::int64_t>(steps.size()));
    const auto relax_tile = [&](const Tile& tile) {
        const auto& [core, grown] = tile;
        RingedGrid<T> residual(grown.rows, grown.cols, 0, 0);
        RingedGrid<T> e(grown.rows, grown.cols, ring, ring);
        RingedGrid<T> next(grown.rows, grown.cols, ring, ring);
        copy_box(samples, grown.row0, grown.col0, residual.box);
        if (start.data) {
            copy_box(start, grown.row0, grown.col0, e.box);
            extend_ring(e);
            add_correlation(residual.box, T(1), minus_mask, e.box, residual.box);
        }
        for (std::int64_t r = 0; r < grown.rows; ++r) {
            const RowTap<T> first{residual.box.row(r), static_cast<T>(steps[0])};
            row_fir(e.box.row(r), grown.cols, &first, 1);
        }
        for (std::size_t k = 1; k < steps.size(); ++k) {
            extend_ring(e);
            add_correlation(residual.box, static_cast<T>(steps[k]),
                            relaxation_mask(mask, 1, steps[k]), e.box, next.box);
            std::swap(e, next);
        }
        for (std::int64_t r = 0; r < core.rows; ++r) {
            const T* correction = e.box.row(core.row0 + r - grown.row0) + (core.col0 - grown.col0);
            const T* old = start.data ? start.row(core.row0 + r) + core.col0 : correction;
            const RowTap<T> taps[] = {{correction, T(1)}, {old, T(1)}};
            row_fir(out.row(core.row0 + r) + core.col0, core.cols, taps, start.data ? 2 : 1);
        }
    };
    parallel_for(0, tiles.count(), 1, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t k = first; k < last; ++k) relax_tile(tiles[k]);
    });
}

/// Smallest value of the symbol of B, at the corner of the Brillouin zone: e1 and e2 turn the phase
/// by a third.
double symbol_minimum(const std::vector<MaskTap>& samples) {
    double sum = 0;
    for (const MaskTap& tap : samples) sum += tap.weight * ((tap.i + tap.j) % 3 == 0 ? 1 : -0.5);
    return sum;
}

/// A cycle of Chebyshev relaxations: the steps, and the factor by which they reduce an error.
struct Cycle {
    std::vector<double> steps;
    double reduction = 1;
};

/// Eight steps for a spectrum in [low, 1], in the order of Lebedev and Finogenov, which keeps
/// partial products small. The interval is widened until 1 is a root: at a border B has Jordan
/// blocks there, which would reduce slowly.
Cycle chebyshev_cycle(double low) {
    constexpr int kOrdering[] = {1, 15, 7, 9, 3, 13, 5, 11};
    constexpr double kPi = 3.14159265358979323846;
    const double radius = (1 - low) / (1 + std::cos(kPi / 16));
    Cycle cycle;
    for (const int k : kOrdering)
        cycle.steps.push_back(1 / (low + radius * (1 + std::cos(kPi * k / 16))));
    const double root = std::sqrt(low / (low + 2 * radius));
    cycle.reduction =
        2 * std::pow((1 - root) / (1 + root), static_cast<double>(cycle.steps.size()));
    return cycle;
}

}  // namespace

template <class T>
Status sample_lattice(int order, GridView<const T> coefficients, GridView<T> samples) {
    RELIEF_CHECK(check(order, coefficients, samples));
    const std::vector<MaskTap>& mask = box_spline(order).samples;
    const int ring = order - 1;
    const Tiling tiles(coefficients.rows, coefficients.cols, ring);
    parallel_for(0, tiles.count(), 1, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t k = first; k < last; ++k) {
            const auto [core, grown] = tiles[k];
            RingedGrid<T> c(grown.rows, grown.cols, ring, ring);
            copy_box(coefficients, grown.row0, grown.col0, c.box);
            extend_ring(c);
            const GridView<T> inner(c.box.row(core.row0 - grown.row0) + (core.col0 - grown.col0),
                                    core.rows, core.cols, c.box.stride);
            for (std::int64_t r = 0; r < core.rows; ++r)
                correlate_row(mask, inner, r, samples.row(core.row0 + r) + core.col0, core.cols);
        }
    });
    return {};
}

template <class T>
Status sample_lattice_adjoint(int order, GridView<const T> residuals, GridView<T> out) {
    RELIEF_CHECK(check(order, residuals, out));
    const std::vector<MaskTap>& mask = box_spline(order).samples;
    const int ring = order - 1;
    const std::int64_t rows = residuals.rows;
    const std::int64_t last_col = residuals.cols - 1;
    // B symmetric without a border: spread the residuals onto box and ring, then fold the ring
    // back, columns first.
    RingedGrid<T> spread(rows, residuals.cols, ring, ring);
    parallel_for(-ring, rows + ring, kRowGrain, [&](std::int64_t first, std::int64_t last) {
        // Two rings: one is the extent of the result, one the reach of the mask from there.
        const RingedGrid<T> source = zero_extended(residuals, first, last, 2 * ring);
        const GridView<T> shifted(source.box.data - ring, source.box.rows, source.box.cols,
                                  source.box.stride);
        for (std::int64_t r = first; r < last; ++r) {
            T* row = spread.box.row(r);
            correlate_row(mask, shifted, r - first, row - ring, residuals.cols + 2 * ring);
            for (std::int64_t k = 1; k <= ring; ++k) {
                row[0] += T(2) * row[-k];
                row[std::min(k, last_col)] -= row[-k];
                row[last_col] += T(2) * row[last_col + k];
                row[std::max<std::int64_t>(last_col - k, 0)] -= row[last_col + k];
            }
        }
    });
    const auto fold_row = [&](std::int64_t ghost, std::int64_t mirror, std::int64_t source) {
        const RowTap<T> twice{spread.box.row(ghost), T(2)};
        const RowTap<T> minus{spread.box.row(ghost), T(-1)};
        row_fir_add(spread.box.row(mirror), residuals.cols, &twice, 1);
        row_fir_add(spread.box.row(source), residuals.cols, &minus, 1);
    };
    for (std::int64_t k = 1; k <= ring; ++k) {
        fold_row(-k, 0, std::min(k, rows - 1));
        fold_row(rows - 1 + k, rows - 1, std::max<std::int64_t>(rows - 1 - k, 0));
    }
    copy_rows<T>(spread.box, out);
    return {};
}

template <class T>
Status interpolate_lattice(int order, GridView<const T> samples, GridView<T> coefficients) {
    RELIEF_CHECK(check(order, samples, coefficients));
    if (order == 1) {
        copy_rows(samples, coefficients);
        return {};
    }
    const Cycle cycle = chebyshev_cycle(symbol_minimum(box_spline(order).samples));
    const double tolerance = std::is_same_v<T, float> ? 2e-8 : 1e-16;
    const int cycles = static_cast<int>(std::ceil(std::log(tolerance) / std::log(cycle.reduction)));
    Grid<T> other(samples.rows, samples.cols);
    GridView<const T> from;
    for (int left = cycles; left > 0; --left) {
        const GridView<T> to = left % 2 ? coefficients : other.view();
        relax(order, samples, from, cycle.steps, to);
        from = to;
    }
    return {};
}

template <class T>
Status quasi_interpolate(int order, GridView<const T> samples, GridView<T> coefficients) {
    RELIEF_CHECK(check(order, samples, coefficients));
    relax(order, samples, GridView<const T>(),
          std::vector<double>(static_cast<std::size_t>(order), 1.0), coefficients);
    return {};
}

template <class T>
Status gram_apply(int order, GridView<const T> coefficients, GridView<T> out) {
    RELIEF_CHECK(check(order, coefficients, out));
    const std::vector<MaskTap>& mask = box_spline(order).gram;
    parallel_for(0, coefficients.rows, kRowGrain, [&](std::int64_t first, std::int64_t last) {
        const RingedGrid<T> source = zero_extended(coefficients, first, last, 2 * order - 1);
        for (std::int64_t r = first; r < last; ++r)
            correlate_row(mask, source.box, r - first, out.row(r), coefficients.cols);
    });
    return {};
}

#define RELIEF_LATTICE_FILTERS(T)                                                \
    template Status sample_lattice(int, GridView<const T>, GridView<T>);         \
    template Status sample_lattice_adjoint(int, GridView<const T>, GridView<T>); \
    template Status interpolate_lattice(int, GridView<const T>, GridView<T>);    \
    template Status quasi_interpolate(int, GridView<const T>, GridView<T>);      \
    template Status gram_apply(int, GridView<const T>, GridView<T>);
RELIEF_LATTICE_FILTERS(float)
RELIEF_LATTICE_FILTERS(double)
#undef RELIEF_LATTICE_FILTERS

}  // namespace relief::spline
