#include "codec/lattice_fill.h"

#include <algorithm>

#include "codec/fast_rows.h"
#include "codec/fast_samples.h"
#include "codec/sample_rows.h"

namespace relief::codec {

namespace {

using namespace fast;

/// The rows of a filled level, one at a time, made of those of the coarser one: row i of `even` is
/// row 2 i of the level.
class FilledRows {
  public:
    FilledRows(const LatticeLevel& coarse, std::int64_t rows, std::int64_t cols)
        : even_(coarse.values),
          rule_(coarse.lowest, coarse.highest, 1),
          even_cols_((cols + 1) / 2),
          diagonal_cols_(cols / 2),
          diagonal_rows_(rows / 2),
          diagonal_(4, diagonal_cols_),
          edge_(1, even_cols_),
          merged_(1, 2 * even_cols_) {
        make_diagonal(-1);
        make_diagonal(0);
    }

    /// Row r, for r = 0, 1, 2 ..
    const std::int32_t* row(std::int64_t r) {
        const std::int64_t i = r / 2;
        if (r % 2 == 0) {
            predict_row(edge_neighbours(diagonal(i - 1), diagonal(i), even_.row(i - 1),
                                        even_.row(i), even_.row(i + 1)),
                        diagonal_cols_, rule_, edge_.row(0));
            merge_values(even_.row(i), edge_.row(0), even_cols_, rule_, merged_.row(0));
        } else {
            make_diagonal(i + 1);
            predict_row(edge_neighbours(even_.row(i), even_.row(i + 1), diagonal(i - 1) - 1,
                                        diagonal(i) - 1, diagonal(i + 1) - 1),
                        even_cols_, rule_, edge_.row(0));
            merge_values(edge_.row(0), diagonal(i), even_cols_, rule_, merged_.row(0));
        }
        return merged_.row(0);
    }

  private:
    std::int32_t* diagonal(std::int64_t i) { return diagonal_.row(i & 3); }

    /// D row i, in the margin too.
    void make_diagonal(std::int64_t i) {
        if (i < 0 || i >= diagonal_rows_) {
            for (std::int64_t k = -1; k <= diagonal_cols_; ++k) make_margin(i, k);
            return;
        }
        predict_row(
            diagonal_neighbours(even_.row(i - 1), even_.row(i), even_.row(i + 1), even_.row(i + 2)),
            diagonal_cols_, rule_, diagonal(i));
        make_margin(i, -1);
        make_margin(i, diagonal_cols_);
    }

    void make_margin(std::int64_t i, std::int64_t k) {
        diagonal(i)[k] =
            margin_mean(even_(i, k), even_(i, k + 1), even_(i + 1, k), even_(i + 1, k + 1));
    }

    const MarginGrid<std::int32_t>& even_;
    RowRule rule_;
    std::int64_t even_cols_;
    std::int64_t diagonal_cols_;
    std::int64_t diagonal_rows_;
    MarginGrid<std::int32_t> diagonal_;  ///< D rows i - 1 .. i + 1
    MarginGrid<std::int32_t> edge_;
    MarginGrid<std::int32_t> merged_;
};

}  // namespace

void fill_level(LatticeLevel& level) {
    const RowRule rule(level.lowest, level.highest, 1);
    SampleRows(level, rule).for_each([&](const SampleRow& row) {
        predict_row(row.neighbours, row.n, rule, row.values);
    });
}

std::int32_t largest_filling_error(LatticeLevel& coarse, GridView<const std::int32_t> samples,
                                   const Grid<std::uint8_t>& valid) {
    reflect_borders(coarse);
    FilledRows rows(coarse, samples.rows, samples.cols);
    std::int32_t largest = 0;
    for (std::int64_t r = 0; r < samples.rows; ++r)
        largest = std::max(
            largest, largest_difference(rows.row(r), samples.row(r),
                                        valid.empty() ? nullptr : valid.row(r), samples.cols));
    return largest;
}

}  // namespace relief::codec
