#include "relief/spline/cubic_filters.h"

#include <algorithm>
#include <vector>

#include "relief/core/parallel.h"
#include "relief/core/rows.h"

namespace relief::spline {

namespace {

/// Columns that are solved together; all rows of a strip stay in a core's own cache.
constexpr std::int64_t kStripCols = 64;
/// Rows that are transposed and solved together.
constexpr std::int64_t kStripRows = 32;

/// The system 4 c(0) + 2 c(1) = 6 v(0), c(i-1) + 4 c(i) + c(i+1) = 6 v(i), and a last row by the
/// kind of end, eliminated forwards: y(i) = pivot(i) (6 v(i) - below(i) y(i-1)), then backwards:
/// c(i) = y(i) - above(i) c(i+1).
template <class T>
struct Elimination {
    Elimination(std::int64_t n, LineEnd end) {
        T last_above = 0;
        for (std::int64_t i = 0; i < n; ++i) {
            const bool last = i == n - 1;
            const T diagonal = last && end == LineEnd::BehindLast ? T(5) : T(4);
            below.push_back(i == 0 ? T(0) : last && end == LineEnd::AtLast ? T(2) : T(1));
            pivot.push_back(1 / (diagonal - below.back() * last_above));
            last_above = pivot.back() * (i == 0 ? T(2) : T(1));
            above.push_back(last_above);
        }
    }
    std::vector<T> below, pivot, above;
};

template <class T>
void solve(const Elimination<T>& rows, const GridView<T>& lines) {
    for (std::int64_t i = 0; i < lines.rows; ++i) {
        const T pivot = rows.pivot[static_cast<std::size_t>(i)];
        const RowTap<T> taps[] = {{lines.row(i), 6 * pivot},
                                  {lines.row(std::max<std::int64_t>(i - 1, 0)),
                                   -(pivot * rows.below[static_cast<std::size_t>(i)])}};
        row_fir(lines.row(i), lines.cols, taps, i == 0 ? 1 : 2);
    }
    for (std::int64_t i = lines.rows - 2; i >= 0; --i) {
        const RowTap<T> tap{lines.row(i + 1), -rows.above[static_cast<std::size_t>(i)]};
        row_fir_add(lines.row(i), lines.cols, &tap, 1);
    }
}

/// Turns the values of every row into coefficients, in place.
template <class T>
void solve_rows(const GridView<T>& lines) {
    if (lines.cols == 1) return;
    const Elimination<T> rows(lines.cols, LineEnd::AtLast);
    parallel_for(0, lines.rows, kStripRows, [&](std::int64_t first, std::int64_t last) {
        const GridView<T> strip(lines.row(first), last - first, lines.cols, lines.stride);
        Grid<T> columns(lines.cols, last - first);
        transpose<T>(strip, columns.view());
        solve(rows, columns.view());
        transpose<T>(columns.view(), strip);
    });
}

}  // namespace

template <class T>
void solve_cubic_columns(GridView<T> lines, LineEnd end) {
    if (lines.rows == 1) return;
    const Elimination<T> rows(lines.rows, end);
    parallel_for(0, lines.cols, kStripCols, [&](std::int64_t first, std::int64_t last) {
        solve(rows, GridView<T>(lines.data + first, lines.rows, last - first, lines.stride));
    });
}

template <class T>
void transpose(GridView<const T> grid, GridView<T> out) {
    constexpr std::int64_t block = 16;
    for (std::int64_t r0 = 0; r0 < grid.rows; r0 += block)
        for (std::int64_t c0 = 0; c0 < grid.cols; c0 += block)
            for (std::int64_t c = c0; c < std::min(c0 + block, grid.cols); ++c)
                for (std::int64_t r = r0; r < std::min(r0 + block, grid.rows); ++r)
                    out(c, r) = grid(r, c);
}

template <class T>
Status interpolate_cubic(GridView<const T> values, GridView<T> coefficients) {
    if (values.rows < 1 || values.cols < 1)
        return Error{ErrorCode::BadInput, "a surface needs at least one value", "values"};
    if (values.rows != coefficients.rows || values.cols != coefficients.cols)
        return Error{ErrorCode::InvalidArgument, "values and coefficients must have the same size",
                     "coefficients"};
    if (coefficients.data != values.data)
        for (std::int64_t r = 0; r < values.rows; ++r)
            std::copy_n(values.row(r), values.cols, coefficients.row(r));
    solve_rows(coefficients);
    solve_cubic_columns(coefficients, LineEnd::AtLast);
    return {};
}

#define RELIEF_CUBIC_FILTERS(T)                              \
    template void solve_cubic_columns(GridView<T>, LineEnd); \
    template void transpose(GridView<const T>, GridView<T>); \
    template Status interpolate_cubic(GridView<const T>, GridView<T>);
RELIEF_CUBIC_FILTERS(float)
RELIEF_CUBIC_FILTERS(double)
#undef RELIEF_CUBIC_FILTERS

}  // namespace relief::spline
