#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "multires/box_rules.h"
#include "relief/core/grid.h"

namespace relief::multires::box {

/// Lines of a fine table that stands for n lines. Integrals differ from their constant in at most 3
/// coarse lines from a border, factors in at most 5 edges, so that a coarse table of 11 lines has a
/// constant middle; 20 and 21 are the fine sizes of either parity that lead to 11.
constexpr std::int64_t table_size(std::int64_t n) {
    return n <= 21 ? n : 20 + n % 2;
}

/// The index into a table of `table` entries that stands for index k of n; the table's middle entry
/// stands for all that are far from both ends. The identity if table == n. Requires table <= n.
constexpr std::int64_t table_index(std::int64_t k, std::int64_t n, std::int64_t table) {
    const std::int64_t middle = (table - 1) / 2;
    if (k <= middle) return k;
    const std::int64_t from_end = n - 1 - k;
    return from_end < table - 1 - middle ? table - 1 - from_end : middle;
}

/// The factors f_e of one level's update, which keep the mean of every wavelet zero near the
/// border: the integral of the edge's function over the weighted integrals of its targets. Exactly
/// 1 a few edges away from the border, where the tables are collapsed, so that their size does not
/// depend on that of the level.
class UpdateFactors {
  public:
    UpdateFactors(Lattice lattice, std::array<Grid<double>, kEdgeKinds> tables)
        : lattice_(lattice), tables_(std::move(tables)) {}

    [[nodiscard]] double at(int kind, std::int64_t i, std::int64_t j) const;

    /// coefficients[j] *= factor of edge (kind, i, j), for the whole row.
    template <class T>
    void scale_row(int kind, std::int64_t i, T* coefficients) const;

  private:
    Lattice lattice_;
    std::array<Grid<double>, kEdgeKinds> tables_;
};

/// The factors of levels 1 .. levels of a rows x cols raster with rows, cols >= 2. Time and memory
/// O(levels).
[[nodiscard]] std::vector<UpdateFactors> update_factors(int order, std::int64_t rows,
                                                        std::int64_t cols, int levels);

}  // namespace relief::multires::box
