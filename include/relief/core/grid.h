#pragma once

#include <algorithm>
#include <cstdint>

#include "relief/core/buffer.h"

/// Two-dimensional arrays. Index (row, col) is (i, j) of the lattice formulas: e1 = one row down,
/// e2 = one column right, e3 = (-1, -1).
namespace relief {

/// A rectangle of lattice points: rows row0 .. row0 + rows - 1, columns col0 .. col0 + cols - 1.
struct LatticeBox {
    std::int64_t row0 = 0;
    std::int64_t col0 = 0;
    std::int64_t rows = 0;
    std::int64_t cols = 0;

    [[nodiscard]] std::int64_t count() const { return rows * cols; }
    [[nodiscard]] bool contains(std::int64_t row, std::int64_t col) const {
        return row >= row0 && row < row0 + rows && col >= col0 && col < col0 + cols;
    }
    friend bool operator==(const LatticeBox&, const LatticeBox&) = default;
};

/// What two boxes share: no rows or no columns if it is nothing.
[[nodiscard]] inline LatticeBox intersection(const LatticeBox& a, const LatticeBox& b) {
    const std::int64_t row0 = std::max(a.row0, b.row0);
    const std::int64_t col0 = std::max(a.col0, b.col0);
    const std::int64_t rows = std::min(a.row0 + a.rows, b.row0 + b.rows) - row0;
    const std::int64_t cols = std::min(a.col0 + a.cols, b.col0 + b.cols) - col0;
    return {row0, col0, std::max<std::int64_t>(rows, 0), std::max<std::int64_t>(cols, 0)};
}

/// The same box in coordinates whose origin is at (row0, col0).
[[nodiscard]] inline LatticeBox relative(const LatticeBox& box, std::int64_t row0,
                                         std::int64_t col0) {
    return {box.row0 - row0, box.col0 - col0, box.rows, box.cols};
}

/// A view of rows x cols elements; row r starts at data + r * stride. T may be const.
template <class T>
struct GridView {
    T* data = nullptr;
    std::int64_t rows = 0;
    std::int64_t cols = 0;
    std::int64_t stride = 0;

    GridView() = default;
    GridView(T* first, std::int64_t row_count, std::int64_t col_count, std::int64_t row_stride)
        : data(first), rows(row_count), cols(col_count), stride(row_stride) {}
    /// A view of mutable elements is also a view of const ones.
    template <class U>
    requires std::is_same_v<const U, T> GridView(const GridView<U>& o)
        : data(o.data), rows(o.rows), cols(o.cols), stride(o.stride) {}  // NOLINT

    [[nodiscard]] T* row(std::int64_t r) const { return data + r * stride; }
    T& operator()(std::int64_t r, std::int64_t c) const { return data[r * stride + c]; }
    [[nodiscard]] std::int64_t count() const { return rows * cols; }
};

/// The elements of a box; one that is empty may be anywhere. Requires: otherwise it is inside.
template <class T>
[[nodiscard]] GridView<T> part_of(const GridView<T>& grid, const LatticeBox& box) {
    T* first = box.count() > 0 ? &grid(box.row0, box.col0) : nullptr;
    return {first, box.rows, box.cols, grid.stride};
}

/// An owned grid; rows are cache-line aligned. Elements are NOT initialised by the sized
/// constructor. Complexity: construction O(1) apart from page faults on first touch.
template <class T>
class Grid {
  public:
    Grid() = default;
    Grid(std::int64_t rows, std::int64_t cols)
        : rows_(rows),
          cols_(cols),
          stride_(padded(cols)),
          buffer_(static_cast<std::size_t>(rows * stride_)) {}
    Grid(std::int64_t rows, std::int64_t cols, T value) : Grid(rows, cols) {
        std::fill_n(buffer_.data(), buffer_.size(), value);
    }

    [[nodiscard]] std::int64_t rows() const { return rows_; }
    [[nodiscard]] std::int64_t cols() const { return cols_; }
    [[nodiscard]] std::int64_t stride() const { return stride_; }
    [[nodiscard]] std::int64_t count() const { return rows_ * cols_; }
    [[nodiscard]] bool empty() const { return count() == 0; }
    T* row(std::int64_t r) { return buffer_.data() + r * stride_; }
    [[nodiscard]] const T* row(std::int64_t r) const { return buffer_.data() + r * stride_; }
    T& operator()(std::int64_t r, std::int64_t c) { return buffer_.data()[r * stride_ + c]; }
    const T& operator()(std::int64_t r, std::int64_t c) const {
        return buffer_.data()[r * stride_ + c];
    }

    [[nodiscard]] GridView<T> view() { return {buffer_.data(), rows_, cols_, stride_}; }
    [[nodiscard]] GridView<const T> view() const { return {buffer_.data(), rows_, cols_, stride_}; }

    [[nodiscard]] Grid clone() const {
        Grid copy(rows_, cols_);
        for (std::int64_t r = 0; r < rows_; ++r) std::copy_n(row(r), cols_, copy.row(r));
        return copy;
    }

  private:
    /// Rows start on cache lines, and never a multiple of 4096 bytes apart (rows would share cache
    /// sets).
    static std::int64_t padded(std::int64_t cols) {
        constexpr std::int64_t line = 64 / static_cast<std::int64_t>(sizeof(T));
        if (cols < line) return cols;
        const std::int64_t stride = (cols + line - 1) / line * line;
        return stride * static_cast<std::int64_t>(sizeof(T)) % 4096 == 0 ? stride + line : stride;
    }

    std::int64_t rows_ = 0;
    std::int64_t cols_ = 0;
    std::int64_t stride_ = 0;
    Buffer<T> buffer_;
};

}  // namespace relief
