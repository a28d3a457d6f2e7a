#include "codec/fast_planes.h"

#include <algorithm>

namespace relief::codec::fast {

LatticePlanes::LatticePlanes(LatticeLevel& level, const RowRule& rule)
    : rule_(rule),
      even_((level.rows() + 1) / 2, (level.cols() + 1) / 2),
      diagonal_(level.rows() / 2, level.cols() / 2),
      edges_(2, (level.cols() + 1) / 2) {
    constexpr std::int64_t reach = 2;
    const std::int64_t rows = even_.values.rows();
    const std::int64_t cols = even_.values.cols();
    for (std::int64_t i = -reach; i < rows + reach; ++i)
        split_values(level.values.row(2 * i) - 2 * reach, cols + 2 * reach, rule,
                     even_.values.row(i) - reach);
    for (std::int64_t i = 0; i < rows; ++i)
        split_quotients(level.quotients.row(2 * i), cols, even_.quotients.row(i));
    // The neighbours of D points in margins are EE: they need not wait for the D samples.
    fill_diagonal_margins(level);
    copy_diagonal_margins(level);
}

void LatticePlanes::copy_diagonal_margins(const LatticeLevel& level) {
    MarginGrid<std::int32_t>& values = diagonal_.values;
    const auto copy = [&](std::int64_t i, std::int64_t j) {
        split_values(&level.values(2 * i + 1, 2 * j + 1), 1, rule_, &values(i, j));
    };
    for (std::int64_t i = 0; i < values.rows(); ++i) {
        copy(i, -1);
        copy(i, values.cols());
    }
    for (std::int64_t j = -1; j <= values.cols(); ++j) {
        copy(-1, j);
        copy(values.rows(), j);
    }
}

Neighbours LatticePlanes::diagonal_neighbours(std::int64_t i) const {
    const std::int32_t* above = even_.values.row(i);
    const std::int32_t* below = even_.values.row(i + 1);
    const std::int32_t* far_above = even_.values.row(i - 1);
    const std::int32_t* far_below = even_.values.row(i + 2);
    const std::int16_t* q_above = even_.quotients.row(i);
    const std::int16_t* q_below = even_.quotients.row(i + 1);
    const std::int16_t* q_earlier = diagonal_.quotients.row(i - 1);
    return {{above, below + 1, above + 1, below},
            {above - 1, above + 2, below - 1, below + 2, far_above, far_above + 1, far_below,
             far_below + 1},
            {q_above, q_below + 1, q_above + 1, q_below},
            {q_earlier, q_earlier + 1}};
}

Neighbours LatticePlanes::edge_neighbours(std::int64_t r) const {
    const std::int64_t i = r / 2;
    const bool odd = r % 2 != 0;
    // `beside` holds the samples left and right of the row's, `across` those above and below; in
    // both, `left` is the column of the left neighbour of sample 0.
    const Kind& beside = odd ? diagonal_ : even_;
    const Kind& across = odd ? even_ : diagonal_;
    const std::int64_t left = odd ? -1 : 0;
    const std::int64_t above = odd ? i : i - 1;
    const std::int32_t* row = beside.values.row(i) + left;
    const std::int32_t* north = across.values.row(above);
    const std::int32_t* south = across.values.row(above + 1);
    const std::int32_t* far_north = beside.values.row(i - 1) + left;
    const std::int32_t* far_south = beside.values.row(i + 1) + left;
    const std::int16_t* q_row = beside.quotients.row(i) + left;
    const std::int16_t* q_earlier = edges_.quotients.row(odd ? 0 : 1) + left;
    return {{north, south, row, row + 1},
            {far_north, far_north + 1, far_south, far_south + 1, north - 1, north + 1, south - 1,
             south + 1},
            {across.quotients.row(above), across.quotients.row(above + 1), q_row, q_row + 1},
            {q_earlier, q_earlier + 1}};
}

void LatticePlanes::merge_row(std::int64_t r, LatticeLevel& level) const {
    const std::int64_t i = r / 2;
    const bool odd = r % 2 != 0;
    const std::int32_t* edge = edges_.values.row(r % 2);
    const std::int16_t* q_edge = edges_.quotients.row(r % 2);
    // Rows of odd width end with half a pair, whose other half is a margin and stays as it is.
    if (odd) {
        merge_values(edge, diagonal_.values.row(i), edge_cols(r), rule_, level.values.row(r));
        merge_quotients(q_edge, diagonal_.quotients.row(i), edge_cols(r), level.quotients.row(r));
    } else {
        merge_values(even_.values.row(i), edge, edge_cols(r), rule_, level.values.row(r));
        merge_quotients(even_.quotients.row(i), q_edge, edge_cols(r), level.quotients.row(r));
    }
}

}  // namespace relief::codec::fast
