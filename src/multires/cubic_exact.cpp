#include "multires/cubic_exact.h"

#include "relief/core/parallel.h"
#include "relief/core/rows.h"
#include "relief/spline/cubic_filters.h"

namespace relief::multires::cubic {

namespace {

constexpr std::int64_t kStripRows = 32;
constexpr std::int64_t kStripCols = 64;

/// The cubic B-spline at 3/2, 1/2, -1/2, -3/2.
constexpr double kHalfwayWeights[4] = {1.0 / 48, 23.0 / 48, 23.0 / 48, 1.0 / 48};

/// The even and the odd members of some columns, one member a row.
template <class T>
struct Lines {
    GridView<T> even;
    GridView<T> odd;
    [[nodiscard]] GridView<T> operator[](Parity parity) const {
        return parity == Parity::Even ? even : odd;
    }
};

template <class T>
void copy(GridView<const T> from, GridView<T> to) {
    for (std::int64_t r = 0; r < from.rows; ++r) std::copy_n(from.row(r), from.cols, to.row(r));
}

/// out(i) += factor * (weighted sum of the four members of `from` around it).
template <class T>
void add_halfway(const Axis& axis, Parity parity, double factor, GridView<const T> from,
                 GridView<T> out) {
    for (std::int64_t i = 0; i < out.rows; ++i) {
        RowTap<T> taps[4];
        for (std::int64_t k = 0; k < 4; ++k) {
            const std::int64_t beside = i + k - (parity == Parity::Odd ? 1 : 2);
            taps[k] = {from.row(axis.mirrored(other(parity), beside)),
                       static_cast<T>(factor * kHalfwayWeights[k])};
        }
        row_fir_add(out.row(i), out.cols, taps, 4);
    }
}

/// Both steps of a level along the columns. With S the sum of the four and B the interpolation, odd
/// members receive S B^-1 (even), even members the transpose of that, B^-1 S^T (odd).
template <class T>
void lift_columns(const Lifting& lifting, std::int64_t n, const Lines<T>& lines) {
    if (n == 1 || lines.even.cols == 0) return;
    const Axis axis{n, {0, (n + 1) / 2}};
    const auto end = n % 2 == 1 ? spline::LineEnd::AtLast : spline::LineEnd::BehindLast;
    Grid<T> solved(lines.even.rows, lines.even.cols);
    for (const Parity parity : {lifting.first, other(lifting.first)}) {
        if (parity == Parity::Odd) {
            copy<T>(lines.even, solved.view());
            spline::solve_cubic_columns(solved.view(), end);
            add_halfway<T>(axis, parity, lifting.odd, solved.view(), lines.odd);
        } else {
            for (std::int64_t i = 0; i < solved.rows(); ++i)
                std::fill_n(solved.row(i), solved.cols(), T(0));
            add_halfway<T>(axis, parity, lifting.even, lines.odd, solved.view());
            spline::solve_cubic_columns(solved.view(), end);
            for (std::int64_t i = 0; i < solved.rows(); ++i) {
                const RowTap<T> tap{solved.row(i), T(1)};
                row_fir_add(lines.even.row(i), solved.cols(), &tap, 1);
            }
        }
    }
}

/// Lifts along the columns of both pairs of bands, strip by strip.
template <class T>
void lift_bands(const Lifting& lifting, std::int64_t rows, const Bands<T>& bands) {
    for (const Parity col : {Parity::Even, Parity::Odd}) {
        const GridView<T>& even = bands[channel(Parity::Even, col)].view;
        const GridView<T>& odd = bands[channel(Parity::Odd, col)].view;
        parallel_for(0, even.cols, kStripCols, [&](std::int64_t first, std::int64_t last) {
            const auto strip = [&](const GridView<T>& band) {
                return GridView<T>(band.data + first, band.rows, last - first, band.stride);
            };
            lift_columns(lifting, rows, Lines<T>{strip(even), rows > 1 ? strip(odd) : odd});
        });
    }
}

/// A strip of rows with its columns as rows.
template <class T>
struct TurnedStrip {
    TurnedStrip(std::int64_t cols, std::int64_t rows)
        : members{Grid<T>((cols + 1) / 2, rows), Grid<T>(cols / 2, rows)} {}
    [[nodiscard]] Lines<T> lines() { return {members[0].view(), members[1].view()}; }
    Grid<T> members[2];
};

constexpr Parity parity_of(std::int64_t row) {
    return row % 2 == 0 ? Parity::Even : Parity::Odd;
}

}  // namespace

template <class T>
void split_level_exactly(const Lifting& lifting, GridView<const T> fine, const Bands<T>& bands) {
    parallel_for(0, fine.rows, kStripRows, [&](std::int64_t first, std::int64_t last) {
        TurnedStrip<T> strip(fine.cols, last - first);
        for (std::int64_t r = first; r < last; ++r)
            for (std::int64_t c = 0; c < fine.cols; ++c)
                strip.members[c % 2](c / 2, r - first) = fine(r, c);
        lift_columns(lifting, fine.cols, strip.lines());
        for (std::int64_t r = first; r < last; ++r)
            for (const Parity col : {Parity::Even, Parity::Odd}) {
                const Grid<T>& members = strip.members[index(col)];
                const GridView<T>& band = bands[channel(parity_of(r), col)].view;
                for (std::int64_t c = 0; c < band.cols; ++c) band(r / 2, c) = members(c, r - first);
            }
    });
    lift_bands(lifting, fine.rows, bands);
}

template <class T>
void merge_level_exactly(const Bands<const T>& bands, GridView<T> fine) {
    std::array<Grid<T>, 4> lifted;
    Bands<T> parts;
    for (std::size_t k = 0; k < 4; ++k) {
        lifted[k] = Grid<T>(bands[k].view.rows, bands[k].view.cols);
        copy(bands[k].view, lifted[k].view());
        parts[k] = {lifted[k].view(), 0, 0};
    }
    lift_bands(kSynthesis, fine.rows, parts);
    parallel_for(0, fine.rows, kStripRows, [&](std::int64_t first, std::int64_t last) {
        TurnedStrip<T> strip(fine.cols, last - first);
        for (std::int64_t r = first; r < last; ++r)
            for (const Parity col : {Parity::Even, Parity::Odd}) {
                Grid<T>& members = strip.members[index(col)];
                const GridView<T>& band = parts[channel(parity_of(r), col)].view;
                for (std::int64_t c = 0; c < band.cols; ++c) members(c, r - first) = band(r / 2, c);
            }
        lift_columns(kSynthesis, fine.cols, strip.lines());
        for (std::int64_t r = first; r < last; ++r)
            for (std::int64_t c = 0; c < fine.cols; ++c)
                fine(r, c) = strip.members[c % 2](c / 2, r - first);
    });
}

#define RELIEF_INSTANTIATE(T)                                                              \
    template void split_level_exactly(const Lifting&, GridView<const T>, const Bands<T>&); \
    template void merge_level_exactly(const Bands<const T>&, GridView<T>);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::cubic
