#pragma once

#include <algorithm>
#include <cstdint>

#include "relief/core/grid.h"
#include "relief/core/rows.h"

namespace relief::spline {

/// A box of coefficients inside a larger allocation: rows -before .. rows + after - 1 of `box`, and
/// columns alike, can be read and written.
template <class T>
struct RingedGrid {
    RingedGrid(std::int64_t rows, std::int64_t cols, int ring_before, int ring_after)
        : storage(rows + ring_before + ring_after, cols + ring_before + ring_after),
          before(ring_before),
          after(ring_after),
          box(storage.row(before) + before, rows, cols, storage.stride()) {}

    Grid<T> storage;
    int before;
    int after;
    GridView<T> box;
};

/// Fills the ring by reflection in the outermost values, first rows, then columns:
/// c(-k) = 2 c(0) - c(min(k, n - 1)) and likewise at the far end; planes continue as planes, n = 1
/// as a constant.
template <class T>
void extend_ring(RingedGrid<T>& grid) {
    const GridView<T>& box = grid.box;
    const std::int64_t last_row = box.rows - 1;
    const std::int64_t last_col = box.cols - 1;
    const auto reflect_row = [&](std::int64_t target, std::int64_t mirror, std::int64_t source) {
        const RowTap<T> taps[] = {{box.row(mirror), T(2)}, {box.row(source), T(-1)}};
        row_fir(box.row(target), box.cols, taps, 2);
    };
    for (std::int64_t k = 1; k <= grid.before; ++k) reflect_row(-k, 0, std::min(k, last_row));
    for (std::int64_t k = 1; k <= grid.after; ++k)
        reflect_row(last_row + k, last_row, std::max<std::int64_t>(last_row - k, 0));
    for (std::int64_t r = -grid.before; r < box.rows + grid.after; ++r) {
        T* row = box.row(r);
        for (std::int64_t k = 1; k <= grid.before; ++k)
            row[-k] = T(2) * row[0] - row[std::min(k, last_col)];
        for (std::int64_t k = 1; k <= grid.after; ++k)
            row[last_col + k] = T(2) * row[last_col] - row[std::max<std::int64_t>(last_col - k, 0)];
    }
}

/// Copies rows first_row .. and columns first_col .. of `source` over the whole box.
template <class T>
void copy_box(const GridView<const T>& source, std::int64_t first_row, std::int64_t first_col,
              const GridView<T>& target) {
    for (std::int64_t r = 0; r < target.rows; ++r)
        std::copy_n(source.row(first_row + r) + first_col, target.cols, target.row(r));
}

}  // namespace relief::spline
