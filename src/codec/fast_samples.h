#pragma once

#include <array>
#include <cstdint>

#include "codec/fast_rows.h"
#include "codec/lattice_level.h"

namespace relief::codec::fast {

/// Where the values lie that predict D samples, of four rows of EE samples: element k of the inner
/// two is to the west of sample k.
Neighbours diagonal_neighbours(const std::int32_t* far_north, const std::int32_t* north,
                               const std::int32_t* south, const std::int32_t* far_south);
/// The same for E samples. Elements k of `north` and `south` are above and below sample k, elements
/// k of `row` and of its like two rows up and down to its west.
Neighbours edge_neighbours(const std::int32_t* north, const std::int32_t* south,
                           const std::int32_t* far_north, const std::int32_t* row,
                           const std::int32_t* far_south);

/// A row of D or E samples of a level: columns col0, col0 + 2, .. of row r.
struct SampleRow {
    std::int64_t r;
    std::int64_t col0;
    std::int64_t n;
    Neighbours neighbours;
    std::int32_t* values;     ///< where its values are to be put, relative to the rule's origin,
    std::int16_t* quotients;  ///< and its quotients
};

/// The rows of a level around those being decoded, by kind, contiguous for vector kernels: few
/// enough to stay in the cache. Row i of a kind is row 2 i or 2 i + 1 of the level, and so for
/// columns.
class SampleRows {
  public:
    SampleRows(LatticeLevel& level, const RowRule& rule);

    /// Calls decode(row) for all rows of D and E samples, each after those it is predicted from:
    /// D row i, then the E rows of lattice rows 2 i - 2 and 2 i - 1. The level has all its samples
    /// and margins in the end.
    template <class Decode>
    void for_each(Decode decode) {
        for (std::int64_t i = 0; i <= even_rows(); ++i) {
            advance(i);
            if (i < diagonal_rows()) decode(diagonal_row(i));
            for (std::int64_t r = 2 * i - 2; r < 2 * i; ++r) {
                if (r < 0 || r >= level_.rows()) continue;
                decode(edge_row(r));
                merge_row(r);
            }
        }
        fill_edge_margins(level_);
    }

  private:
    /// Rows i - 2 .. i + 2 are in use at a time.
    static constexpr std::int64_t kRows = 8;
    static constexpr std::int64_t kReach = 2;

    struct Kind {
        MarginGrid<std::int32_t> values_;
        MarginGrid<std::int16_t> quotients_;

        Kind(std::int64_t rows, std::int64_t cols) : values_(rows, cols), quotients_(rows, cols) {}
        std::int32_t* values(std::int64_t i) { return values_.row(i & (values_.rows() - 1)); }
        std::int16_t* quotients(std::int64_t i) { return quotients_.row(i & (values_.rows() - 1)); }
    };

    [[nodiscard]] std::int64_t even_rows() const { return (level_.rows() + 1) / 2; }
    [[nodiscard]] std::int64_t even_cols() const { return (level_.cols() + 1) / 2; }
    [[nodiscard]] std::int64_t diagonal_rows() const { return level_.rows() / 2; }
    [[nodiscard]] std::int64_t diagonal_cols() const { return level_.cols() / 2; }

    /// EE rows up to i + 2, and the margins of D row i.
    void advance(std::int64_t i);
    void load_even_row(std::int64_t i);
    void load_diagonal_margins(std::int64_t i);
    SampleRow diagonal_row(std::int64_t i);
    SampleRow edge_row(std::int64_t r);
    void merge_row(std::int64_t r);

    LatticeLevel& level_;
    RowRule rule_;
    Kind even_;
    Kind diagonal_;
    Kind edge_;  ///< row r of the level
};

}  // namespace relief::codec::fast
