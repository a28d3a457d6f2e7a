#include "codec/fast_samples.h"

#include <algorithm>

namespace relief::codec::fast {

Neighbours diagonal_neighbours(const std::int32_t* far_north, const std::int32_t* north,
                               const std::int32_t* south, const std::int32_t* far_south) {
    Neighbours at{};
    at.near = {north, south + 1, north + 1, south};
    at.far = {north - 1, north + 2,     south - 1, south + 2,
              far_north, far_north + 1, far_south, far_south + 1};
    return at;
}

Neighbours edge_neighbours(const std::int32_t* north, const std::int32_t* south,
                           const std::int32_t* far_north, const std::int32_t* row,
                           const std::int32_t* far_south) {
    Neighbours at{};
    at.near = {north, south, row, row + 1};
    at.far = {far_north, far_north + 1, far_south, far_south + 1,
              north - 1, north + 1,     south - 1, south + 1};
    return at;
}

SampleRows::SampleRows(LatticeLevel& level, const RowRule& rule)
    : level_(level),
      rule_(rule),
      even_(kRows, even_cols()),
      diagonal_(kRows, diagonal_cols()),
      edge_(2, even_cols()) {
    // The neighbours of D points in margins are EE: they need not wait for the D samples.
    fill_diagonal_margins(level);
    load_even_row(-1);
    load_even_row(0);
    advance(-1);
}

void SampleRows::advance(std::int64_t i) {
    if (i < even_rows()) load_even_row(i + kReach);
    load_diagonal_margins(i);
}

void SampleRows::load_even_row(std::int64_t i) {
    split_values(level_.values.row(2 * i) - 2 * kReach, even_cols() + 2 * kReach, rule_,
                 even_.values(i) - kReach);
    if (i >= 0 && i < even_rows()) {
        split_quotients(level_.quotients.row(2 * i), even_cols(), even_.quotients(i));
    } else {
        std::fill_n(even_.quotients(i), even_cols(), std::int16_t{0});
    }
}

void SampleRows::load_diagonal_margins(std::int64_t i) {
    const std::int32_t* from = level_.values.row(2 * i + 1) + 1;
    std::int32_t* to = diagonal_.values(i);
    const std::int64_t cols = diagonal_cols();
    if (i >= 0 && i < diagonal_rows()) {
        split_values(from - 2, 1, rule_, to - 1);
        split_values(from + 2 * cols, 1, rule_, to + cols);
    } else {
        split_values(from - 2, cols + 2, rule_, to - 1);
        std::fill_n(diagonal_.quotients(i), cols, std::int16_t{0});
    }
}

SampleRow SampleRows::diagonal_row(std::int64_t i) {
    const std::int16_t* q_north = even_.quotients(i);
    const std::int16_t* q_south = even_.quotients(i + 1);
    const std::int16_t* q_earlier = diagonal_.quotients(i - 1);
    Neighbours neighbours = diagonal_neighbours(even_.values(i - 1), even_.values(i),
                                                even_.values(i + 1), even_.values(i + 2));
    neighbours.near_quotients = {q_north, q_south + 1, q_north + 1, q_south};
    neighbours.earlier_quotients = {q_earlier, q_earlier + 1};
    return {2 * i + 1, 1, diagonal_cols(), neighbours, diagonal_.values(i), diagonal_.quotients(i)};
}

SampleRow SampleRows::edge_row(std::int64_t r) {
    const std::int64_t i = r / 2;
    const bool odd = r % 2 != 0;
    // `beside` holds the samples left and right of the row's, the left one of sample k at k + left;
    // `across` those above and below.
    Kind& beside = odd ? diagonal_ : even_;
    Kind& across = odd ? even_ : diagonal_;
    const std::int64_t left = odd ? -1 : 0;
    const std::int64_t above = odd ? i : i - 1;
    const std::int16_t* q_row = beside.quotients(i) + left;
    const std::int16_t* q_earlier = edge_.quotients(r - 1) + left;
    Neighbours neighbours =
        edge_neighbours(across.values(above), across.values(above + 1), beside.values(i - 1) + left,
                        beside.values(i) + left, beside.values(i + 1) + left);
    neighbours.near_quotients = {across.quotients(above), across.quotients(above + 1), q_row,
                                 q_row + 1};
    neighbours.earlier_quotients = {q_earlier, q_earlier + 1};
    const std::int64_t n = odd ? even_cols() : diagonal_cols();
    return {r, odd ? 0 : 1, n, neighbours, edge_.values(r), edge_.quotients(r)};
}

void SampleRows::merge_row(std::int64_t r) {
    const std::int64_t i = r / 2;
    std::int32_t* values = level_.values.row(r);
    std::int16_t* quotients = level_.quotients.row(r);
    if (r % 2 == 0) {
        merge_values(even_.values(i), edge_.values(r), diagonal_cols(), rule_, values);
        merge_quotients(even_.quotients(i), edge_.quotients(r), diagonal_cols(), quotients);
    } else {
        // Rows of odd width end with half a pair; its other half is a margin and stays as it is.
        merge_values(edge_.values(r), diagonal_.values(i), even_cols(), rule_, values);
        merge_quotients(edge_.quotients(r), diagonal_.quotients(i), even_cols(), quotients);
    }
}

}  // namespace relief::codec::fast
