#pragma once

#include <array>
#include <cstdint>

#include "codec/fast_rows.h"
#include "codec/lattice_level.h"

namespace relief::codec::fast {

/// The samples of a level by kind, contiguous for vector kernels and relative to the rule's origin:
/// EE and D in planes, the last E row of either parity. Row i of a kind is row 2 i or 2 i + 1 of
/// the level, and so for columns. Made before a level is decoded; set_edges puts samples back.
class LatticePlanes {
  public:
    LatticePlanes(LatticeLevel& level, const RowRule& rule);

    [[nodiscard]] std::int64_t diagonal_rows() const { return diagonal_.values.rows(); }
    [[nodiscard]] std::int64_t diagonal_cols() const { return diagonal_.values.cols(); }
    /// Columns of the E samples in row r of the level.
    [[nodiscard]] std::int64_t edge_cols(std::int64_t r) const {
        return r % 2 == 0 ? diagonal_.values.cols() : even_.values.cols();
    }

    /// Of the D samples in row 2 i + 1 of the level.
    [[nodiscard]] Neighbours diagonal_neighbours(std::int64_t i) const;
    /// Of the E samples in row r of the level.
    [[nodiscard]] Neighbours edge_neighbours(std::int64_t r) const;

    /// Where the row that was predicted is to be put.
    [[nodiscard]] std::int32_t* diagonal_values(std::int64_t i) { return diagonal_.values.row(i); }
    [[nodiscard]] std::int16_t* diagonal_quotients(std::int64_t i) {
        return diagonal_.quotients.row(i);
    }
    [[nodiscard]] std::int32_t* edge_values(std::int64_t r) { return edges_.values.row(r % 2); }
    [[nodiscard]] std::int16_t* edge_quotients(std::int64_t r) {
        return edges_.quotients.row(r % 2);
    }

    /// Row r of the level, all of whose samples are there now.
    void merge_row(std::int64_t r, LatticeLevel& level) const;

  private:
    struct Kind {
        MarginGrid<std::int32_t> values;
        MarginGrid<std::int16_t> quotients;

        Kind(std::int64_t rows, std::int64_t cols) : values(rows, cols), quotients(rows, cols) {}
    };

    void copy_diagonal_margins(const LatticeLevel& level);

    RowRule rule_;
    Kind even_;
    Kind diagonal_;
    Kind edges_;  ///< row 0: of the last even row of the level; row 1: of the last odd row
};

}  // namespace relief::codec::fast
