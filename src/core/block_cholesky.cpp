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

/// A symmetric block to its lower triangular root, whose diagonal is kept inverted; false if a
/// pivot is lost.
bool take_root(Block3& a, const Block3& original, LostPivots lost) {
    for (std::size_t j = 0; j < 3; ++j) {
        double pivot = a[4 * j];
        for (std::size_t k = 0; k < j; ++k) pivot -= a[3 * j + k] * a[3 * j + k];
        if (!keep(pivot, original[4 * j], lost)) return false;
        a[4 * j] = 1 / std::sqrt(pivot);
        for (std::size_t i = j + 1; i < 3; ++i) {
            for (std::size_t k = 0; k < j; ++k) a[3 * i + j] -= a[3 * i + k] * a[3 * j + k];
            a[3 * i + j] *= a[4 * j];
        }
    }
    return true;
}

/// a = a root^-T.
void divide(Block3& a, const Block3& root) {
    for (std::size_t i = 0; i < 9; i += 3) {
        a[i] *= root[0];
        a[i + 1] = (a[i + 1] - a[i] * root[3]) * root[4];
        a[i + 2] = (a[i + 2] - a[i] * root[6] - a[i + 1] * root[7]) * root[8];
    }
}

}  // namespace

std::vector<std::uint32_t> nested_dissection(std::span<const Vec2> points, const GraphView& graph) {
    return Dissection(points, graph).run();
}

BlockCholesky::BlockCholesky(const GraphView& graph, std::vector<Index> order)
    : order_(std::move(order)), place_(order_.size()), root_(order_.size()) {
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
            Block3 entry = row[i];
            row[i] = {};
            divide(entry, root_[i]);
            for (std::uint64_t p = first_[i]; p < end[i]; ++p)
                subtract_product(row[rows_[p]], entry, transposed(lower_[p]));
            subtract_product(pivot, entry, transposed(entry));
            lower_[end[i]++] = entry;
        }
        if (!take_root(pivot, diagonal[v], lost)) return v;
        root_[k] = pivot;
    }
    return count;
}

void BlockCholesky::solve(std::span<Column3> x) const {
    const auto count = static_cast<Index>(order_.size());
    std::vector<Column3> y(count);
    for (Index k = 0; k < count; ++k) y[k] = x[order_[k]];
    for (Index k = 0; k < count; ++k) {
        Column3& own = y[k];
        const Block3& r = root_[k];
        own[0] *= r[0];
        own[1] = (own[1] - r[3] * own[0]) * r[4];
        own[2] = (own[2] - r[6] * own[0] - r[7] * own[1]) * r[8];
        for (std::uint64_t p = first_[k]; p < first_[k + 1]; ++p)
            subtract_product(y[rows_[p]], lower_[p], own);
    }
    for (Index k = count; k-- > 0;) {
        Column3& own = y[k];
        for (std::uint64_t p = first_[k]; p < first_[k + 1]; ++p)
            subtract_product(own, transposed(lower_[p]), y[rows_[p]]);
        const Block3& r = root_[k];
        own[2] *= r[8];
        own[1] = (own[1] - r[7] * own[2]) * r[4];
        own[0] = (own[0] - r[3] * own[1] - r[6] * own[2]) * r[0];
    }
    for (Index k = 0; k < count; ++k) x[order_[k]] = y[k];
}

}  // namespace relief
