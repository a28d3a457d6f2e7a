#include "relief/spline/fvs_grid.h"

#include <algorithm>
#include <string>

#include "relief/core/parallel.h"
#include "relief/core/rows.h"
#include "spline/fvs_estimate.h"
#include "spline/fvs_rows.h"

namespace relief::spline {

namespace {

/// A derivative at sample k of a line: sum of weight (f[k + plus] - f[k + minus]) / denominator.
struct DifferenceRule {
    struct Term {
        int plus;
        int minus;
        double weight;
    };
    int count = 0;
    std::array<Term, 4> terms{};
    double denominator = 1;
};

/// A midpoint value between samples k and k + 1: sum of weights[t] f[k + first + t].
struct MidpointRule {
    int count = 0;
    int first = 0;
    std::array<double, 4> weights{};
};

/// The rule of sample k < n / 2, or of the middle one.
DifferenceRule first_half_rule(std::int64_t k, std::int64_t n) {
    if (n == 1) return {};
    if (n == 2) return {1, {{{1, 0, 1}}}, 1};
    if (n == 3 && k == 0) return {2, {{{1, 0, 4}, {2, 0, -1}}}, 2};
    if (n == 3) return {1, {{{1, -1, 1}}}, 2};
    if (n == 4 && k == 0) return {3, {{{1, 0, 18}, {2, 0, -9}, {3, 0, 2}}}, 6};
    if (n == 4) return {3, {{{-1, 0, -2}, {1, 0, 6}, {2, 0, -1}}}, 6};
    if (k == 0) return {4, {{{1, 0, 48}, {2, 0, -36}, {3, 0, 16}, {4, 0, -3}}}, 12};
    if (k == 1) return {4, {{{-1, 0, -3}, {1, 0, 18}, {2, 0, -6}, {3, 0, 1}}}, 12};
    return {2, {{{1, -1, 8}, {2, -2, -1}}}, 12};
}

DifferenceRule difference_rule(std::int64_t k, std::int64_t n) {
    if (k <= n - 1 - k) return first_half_rule(k, n);
    DifferenceRule rule = first_half_rule(n - 1 - k, n);
    for (int t = 0; t < rule.count; ++t) {
        DifferenceRule::Term& term = rule.terms[std::size_t(t)];
        term = {-term.plus, -term.minus, -term.weight};
    }
    return rule;
}

MidpointRule midpoint_rule(std::int64_t k, std::int64_t n) {
    if (n == 2) return {2, 0, {0.5, 0.5}};
    if (n == 3 && k == 0) return {3, 0, {3 / 8.0, 6 / 8.0, -1 / 8.0}};
    if (n == 3) return {3, -1, {-1 / 8.0, 6 / 8.0, 3 / 8.0}};
    if (k == 0) return {4, 0, {5 / 16.0, 15 / 16.0, -5 / 16.0, 1 / 16.0}};
    if (k == n - 2) return {4, -2, {1 / 16.0, -5 / 16.0, 15 / 16.0, 5 / 16.0}};
    return {4, -1, {-1 / 16.0, 9 / 16.0, 9 / 16.0, -1 / 16.0}};
}

/// Applies `rule` at n neighbouring samples; at(offset) is the line that far from theirs.
template <class T, class At>
void apply(const DifferenceRule& rule, double spacing, std::int64_t n, At at, T* out) {
    RowDifference<T> terms[4];
    for (int t = 0; t < rule.count; ++t) {
        const auto& term = rule.terms[std::size_t(t)];
        terms[t] = {at(term.plus), at(term.minus), static_cast<T>(term.weight)};
    }
    row_differences(out, n, static_cast<T>(1 / (rule.denominator * spacing)), terms, rule.count);
}

template <class T, class At>
void apply(const MidpointRule& rule, std::int64_t n, At at, T* out) {
    RowTap<T> taps[4];
    for (int t = 0; t < rule.count; ++t)
        taps[t] = {at(rule.first + t), static_cast<T>(rule.weights[std::size_t(t)])};
    row_fir(out, n, taps, rule.count);
}

/// Calls run(first, last) for the ranges of [begin, end) that share a rule: single indices within
/// `border` of the ends of 0 .. n - 1, and all that lie between.
template <class Run>
void for_rule_ranges(std::int64_t begin, std::int64_t end, std::int64_t border, std::int64_t n,
                     Run run) {
    const std::int64_t inner_begin = std::clamp(border, begin, end);
    const std::int64_t inner_end = std::clamp(n - border, inner_begin, end);
    for (std::int64_t k = begin; k < inner_begin; ++k) run(k, k + 1);
    if (inner_begin < inner_end) run(inner_begin, inner_end);
    for (std::int64_t k = inner_end; k < end; ++k) run(k, k + 1);
}

/// Makes nodal data row by row. Each row depends on samples alone: GV is the derivative along x of
/// rows interpolated at their midpoints, GH the interpolation along x of derivatives along y.
template <class T>
class Estimator {
  public:
    Estimator(const RasterPart<T>& part, const LatticeBox& window, FvsGridView<T> out)
        : part_(part),
          window_(window),
          needed_(needed_box(window, part.rows, part.cols)),
          out_(out),
          line_(1, needed_.cols) {}

    void vertex_row(std::int64_t r) {
        const std::int64_t row = window_.row0 + r;
        const T* samples = sample_row(row);
        std::copy_n(samples + (window_.col0 - needed_.col0), window_.cols, out_[kFvsF].row(r));
        along_x(samples, out_[kFvsFx].row(r));
        apply(
            difference_rule(row, part_.rows), out_.b, needed_.cols,
            [&](std::int64_t offset) { return sample_row(row + offset); }, line_.row(0));
        std::copy_n(line_.row(0) + (window_.col0 - needed_.col0), window_.cols,
                    out_[kFvsFy].row(r));
        midpoints_along_x(line_.row(0), out_[kFvsGh].row(r));
    }

    void cell_row(std::int64_t r) {
        const std::int64_t row = window_.row0 + r;
        apply(
            midpoint_rule(row, part_.rows), needed_.cols,
            [&](std::int64_t offset) { return sample_row(row + offset); }, line_.row(0));
        along_x(line_.row(0), out_[kFvsGv].row(r));
    }

  private:
    /// From column needed_.col0 on.
    [[nodiscard]] const T* sample_row(std::int64_t row) const {
        return part_.values.row(row - part_.row0) + (needed_.col0 - part_.col0);
    }

    /// line: from column needed_.col0 on; out: from column window_.col0 on.
    void along_x(const T* line, T* out) const {
        const auto run = [&](std::int64_t first, std::int64_t last) {
            apply(
                difference_rule(first, part_.cols), out_.a, last - first,
                [&](std::int64_t offset) { return line + (first + offset - needed_.col0); },
                out + (first - window_.col0));
        };
        for_rule_ranges(window_.col0, window_.col0 + window_.cols, 2, part_.cols, run);
    }

    void midpoints_along_x(const T* line, T* out) const {
        const auto run = [&](std::int64_t first, std::int64_t last) {
            apply(
                midpoint_rule(first, part_.cols), last - first,
                [&](std::int64_t offset) { return line + (first + offset - needed_.col0); },
                out + (first - window_.col0));
        };
        for_rule_ranges(window_.col0, window_.col0 + window_.cols - 1, 1, part_.cols - 1, run);
    }

    const RasterPart<T>& part_;
    LatticeBox window_;
    LatticeBox needed_;
    FvsGridView<T> out_;
    Grid<T> line_;  ///< of needed_.cols samples
};

bool covers(const LatticeBox& outer, const LatticeBox& inner) {
    return inner.row0 >= outer.row0 && inner.col0 >= outer.col0 &&
           inner.row0 + inner.rows <= outer.row0 + outer.rows &&
           inner.col0 + inner.cols <= outer.col0 + outer.cols;
}

std::string text(const LatticeBox& box) {
    return "rows " + std::to_string(box.row0) + " to " + std::to_string(box.row0 + box.rows - 1) +
           ", columns " + std::to_string(box.col0) + " to " +
           std::to_string(box.col0 + box.cols - 1);
}

/// First and last sample needed for first .. last.
void widen(std::int64_t n, std::int64_t& first, std::int64_t& last) {
    const bool from_begin = first < 2;
    const bool from_end = last >= n - 2;
    first = from_end ? std::min(first - 2, n - 5) : first - 2;
    last = from_begin ? std::max<std::int64_t>(last + 2, 4) : last + 2;
    first = std::max<std::int64_t>(first, 0);
    last = std::min(last, n - 1);
}

}  // namespace

LatticeBox needed_box(const LatticeBox& window, std::int64_t rows, std::int64_t cols) {
    std::int64_t top = window.row0, bottom = window.row0 + window.rows - 1;
    std::int64_t left = window.col0, right = window.col0 + window.cols - 1;
    widen(rows, top, bottom);
    widen(cols, left, right);
    return {top, left, bottom - top + 1, right - left + 1};
}

template <class T>
Status check_fvs_window(const RasterPart<T>& part, const LatticeBox& window) {
    if (window.rows < 1 || window.cols < 1 || !covers({0, 0, part.rows, part.cols}, window))
        return Error{ErrorCode::InvalidArgument,
                     "the window (" + text(window) + ") is empty or leaves the raster of " +
                         std::to_string(part.rows) + " x " + std::to_string(part.cols),
                     "window"};
    const LatticeBox given = {part.row0, part.col0, part.values.rows, part.values.cols};
    const LatticeBox needed = needed_box(window, part.rows, part.cols);
    if (covers(given, needed)) return {};
    return Error{ErrorCode::InvalidArgument,
                 "the samples cover " + text(given) + "; this window needs " + text(needed),
                 "samples"};
}

template <class T>
void estimate_fvs_rows(const RasterPart<T>& part, const LatticeBox& window, std::int64_t first,
                       std::int64_t last, const FvsGridView<T>& grid) {
    Estimator<T> estimator(part, window, grid);
    for (std::int64_t r = first; r < last; ++r) {
        estimator.vertex_row(r);
        if (r < grid.ny()) estimator.cell_row(r);
    }
}

template <class T>
Result<FvsGrid<T>> estimate_fvs_grid(const RasterPart<T>& part, const LatticeBox& window, double a,
                                     double b) {
    if (!(a > 0) || !(b > 0))
        return Error{ErrorCode::InvalidArgument, "the spacing of samples must be positive",
                     "spacing"};
    RELIEF_CHECK(check_fvs_window(part, window));
    FvsGrid<T> grid(window.cols - 1, window.rows - 1, a, b);
    const std::int64_t grain = std::max<std::int64_t>(1, 65536 / window.cols);
    parallel_for(0, window.rows, grain, [&](std::int64_t first, std::int64_t last) {
        estimate_fvs_rows(part, window, first, last, grid.view());
    });
    return grid;
}

#define RELIEF_INSTANTIATE(T)                                                                      \
    template Status check_fvs_window(const RasterPart<T>&, const LatticeBox&);                     \
    template void estimate_fvs_rows(const RasterPart<T>&, const LatticeBox&, std::int64_t,         \
                                    std::int64_t, const FvsGridView<T>&);                          \
    template Result<FvsGrid<T>> estimate_fvs_grid(const RasterPart<T>&, const LatticeBox&, double, \
                                                  double);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::spline
