#include "relief/core/block_cholesky.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace relief {

namespace {

using Index = std::uint32_t;
constexpr Index kNone = std::numeric_limits<Index>::max();
constexpr std::size_t kSmall = 16;  ///< parts that are not halved any more
constexpr double kSingular = 1e-13;
constexpr double kRaised = 1e-8;

/// Cuts parts of `order_` in place.
class Dissection {
  public:
    Dissection(std::span<const Vec2> points, const GraphView& graph)
        : points_(points), graph_(graph), order_(graph.size()), side_(graph.size(), 0) {
        std::iota(order_.begin(), order_.end(), Index{0});
    }

    std::vector<Index> run() {
        cut(0, order_.size());
        return std::move(order_);
    }

  private:
    using Place = std::vector<Index>::iterator;

    void cut(std::size_t begin, std::size_t end) {
        while (end - begin > kSmall) {
            const auto first = order_.begin() + static_cast<std::ptrdiff_t>(begin);
            const auto last = order_.begin() + static_cast<std::ptrdiff_t>(end);
            const auto middle = first + (last - first) / 2;
            halve(first, middle, last);
            mark(first, middle, 1);
            mark(middle, last, 2);
            // The separator goes behind the second half.
            const auto has_other = [&](Index v) {
                const auto around = graph_.of(v);
                return std::any_of(around.begin(), around.end(),
                                   [&](Index w) { return side_[w] == 2; });
            };
            const auto separator =
                std::stable_partition(first, middle, [&](Index v) { return !has_other(v); });
            mark(first, last, 0);
            std::rotate(separator, middle, last);
            const auto inner = static_cast<std::size_t>(separator - first);
            const auto other = static_cast<std::size_t>(last - middle);
            cut(begin, begin + inner);
            begin += inner;
            end = begin + other;
        }
    }

    void halve(Place first, Place middle, Place last) const {
        Vec2 low = points_[*first];
        Vec2 high = low;
        for (auto v = first; v != last; ++v) {
            const Vec2 p = points_[*v];
            low = {std::min(low.x, p.x), std::min(low.y, p.y)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
        const bool wide = high.x - low.x >= high.y - low.y;
        std::nth_element(first, middle, last, [&](Index a, Index b) {
            const double p = wide ? points_[a].x : points_[a].y;
            const double q = wide ? points_[b].x : points_[b].y;
            return p != q ? p < q : a < b;
        });
    }

    void mark(Place first, Place last, std::uint8_t side) {
        for (auto v = first; v != last; ++v) side_[*v] = side;
    }

    std::span<const Vec2> points_;
    const GraphView& graph_;
    std::vector<Index> order_;
    std::vector<std::uint8_t> side_;
};

Block3 transposed(const Block3& a) {
    return {a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]};
}

/// c -= a b
void subtract_product(Block3& c, const Block3& a, const Block3& b) {
    for (std::size_t i = 0; i < 9; i += 3)
        for (std::size_t j = 0; j < 3; ++j)
            c[i + j] -= a[i] * b[j] + a[i + 1] * b[3 + j] + a[i + 2] * b[6 + j];
}

Block3 product(const Block3& a, const Block3& b) {
    Block3 c{};
    for (std::size_t i = 0; i < 9; i += 3)
        for (std::size_t j = 0; j < 3; ++j)
            c[i + j] = a[i] * b[j] + a[i + 1] * b[3 + j] + a[i + 2] * b[6 + j];
    return c;
}

void subtract_product(Column3& y, const Block3& a, const Column3& x) {
    for (std::size_t i = 0; i < 3; ++i)
        y[i] -= a[3 * i] * x[0] + a[3 * i + 1] * x[1] + a[3 * i + 2] * x[2];
}

/// A pivot that is only what rounding left of the matrix' own element is lost.
bool keep(double& pivot, double original, LostPivots lost) {
    if (pivot > kSingular * original) return true;
    pivot = kRaised * original;
    return lost == LostPivots::Raise && original > 0;
}

/// Of a symmetric block by its own L D L^T; false if a pivot is lost.
bool invert(const Block3& a, const Block3& original, LostPivots lost, Block3& inverse) {
    double d0 = a[0];
    if (!keep(d0, original[0], lost)) return false;
    const double l10 = a[3] / d0;
    const double l20 = a[6] / d0;
    double d1 = a[4] - l10 * a[3];
    if (!keep(d1, original[4], lost)) return false;
    const double l21 = (a[7] - l20 * a[3]) / d1;
    double d2 = a[8] - l20 * a[6] - l21 * l21 * d1;
    if (!keep(d2, original[8], lost)) return false;
    // Columns of the inverse of L, then L^-T D^-1 L^-1.
    const double m10 = -l10;
    const double m20 = l10 * l21 - l20;
    const double m21 = -l21;
    inverse[0] = 1 / d0 + m10 * m10 / d1 + m20 * m20 / d2;
    inverse[3] = inverse[1] = m10 / d1 + m20 * m21 / d2;
    inverse[6] = inverse[2] = m20 / d2;
    inverse[4] = 1 / d1 + m21 * m21 / d2;
    inverse[7] = inverse[5] = m21 / d2;
    inverse[8] = 1 / d2;
    return true;
}

}  // namespace

std::vector<std::uint32_t> nested_dissection(std::span<const Vec2> points, const GraphView& graph) {
    return Dissection(points, graph).run();
}

BlockCholesky::BlockCholesky(const GraphView& graph, std::vector<Index> order)
    : order_(std::move(order)), place_(order_.size()), inverse_(order_.size()) {
    for (Index k = 0; k < order_.size(); ++k) place_[order_[k]] = k;
    find_pattern(graph);
    lower_.resize(rows_.size());
}

/// Row k of L has blocks at the places between its neighbours and k in the elimination tree.
void BlockCholesky::find_pattern(const GraphView& graph) {
    const auto count = static_cast<Index>(order_.size());
    parent_.assign(count, kNone);
    std::vector<Index> seen(count, kNone);
    std::vector<std::uint64_t> length(count, 0);
    const auto each_of_row = [&](Index k, auto&& visit) {
        seen[k] = k;
        for (const Index w : graph.of(order_[k]))
            for (Index i = place_[w]; i < k && seen[i] != k; i = parent_[i]) {
                if (parent_[i] == kNone) parent_[i] = k;
                seen[i] = k;
                visit(i);
            }
    };
    for (Index k = 0; k < count; ++k) each_of_row(k, [&](Index i) { ++length[i]; });
    first_.assign(count + 1, 0);
    for (Index i = 0; i < count; ++i) first_[i + 1] = first_[i] + length[i];
    rows_.resize(first_[count]);
    std::fill(seen.begin(), seen.end(), kNone);
    std::vector<std::uint64_t> next(first_.begin(), first_.end() - 1);
    for (Index k = 0; k < count; ++k) each_of_row(k, [&](Index i) { rows_[next[i]++] = k; });
}

/// Row by row: those of L so far, times the new row, are what the matrix has there.
std::size_t BlockCholesky::factor(const GraphView& graph, std::span<const Block3> diagonal,
                                  std::span<const Block3> off_diagonal, LostPivots lost) {
    const auto count = static_cast<Index>(order_.size());
    std::vector<Block3> row(count, Block3{});
    std::vector<Index> seen(count, kNone);
    std::vector<Index> columns;
    std::vector<std::uint64_t> end(first_.begin(), first_.end() - 1);
    for (Index k = 0; k < count; ++k) {
        const Index v = order_[k];
        columns.clear();
        seen[k] = k;
        for (Index n = graph.first[v]; n < graph.first[v + 1]; ++n) {
            const Index first = place_[graph.items[n]];
            if (first >= k) continue;
            row[first] = off_diagonal[n];
            for (Index i = first; i < k && seen[i] != k; i = parent_[i]) {
                seen[i] = k;
                columns.push_back(i);
            }
        }
        // Children come before their parents in this order.
        std::sort(columns.begin(), columns.end());
        Block3 pivot = diagonal[v];
        for (const Index i : columns) {
            const Block3 entry = row[i];
            row[i] = {};
            const Block3 scaled = product(entry, inverse_[i]);
            for (std::uint64_t p = first_[i]; p < end[i]; ++p)
                subtract_product(row[rows_[p]], entry, transposed(lower_[p]));
            subtract_product(pivot, scaled, transposed(entry));
            lower_[end[i]++] = scaled;
        }
        if (!invert(pivot, diagonal[v], lost, inverse_[k])) return v;
    }
    return count;
}

void BlockCholesky::solve(std::span<Column3> x) const {
    const auto count = static_cast<Index>(order_.size());
    std::vector<Column3> y(count);
    for (Index k = 0; k < count; ++k) y[k] = x[order_[k]];
    for (Index k = 0; k < count; ++k)
        for (std::uint64_t p = first_[k]; p < first_[k + 1]; ++p)
            subtract_product(y[rows_[p]], lower_[p], y[k]);
    for (Index k = count; k-- > 0;) {
        Column3 z{};
        const Block3& d = inverse_[k];
        for (std::size_t i = 0; i < 3; ++i)
            z[i] = d[3 * i] * y[k][0] + d[3 * i + 1] * y[k][1] + d[3 * i + 2] * y[k][2];
        for (std::uint64_t p = first_[k]; p < first_[k + 1]; ++p) {
            const Column3& below = y[rows_[p]];
            const Block3& a = lower_[p];
            for (std::size_t i = 0; i < 3; ++i)
                z[i] -= a[i] * below[0] + a[3 + i] * below[1] + a[6 + i] * below[2];
        }
        y[k] = z;
    }
    for (Index k = 0; k < count; ++k) x[order_[k]] = y[k];
}

}  // namespace relief
