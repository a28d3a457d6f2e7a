#pragma once

#include <cstddef>
#include <vector>

namespace relief {

/// A symmetric positive definite band matrix and its Cholesky factors. The same bits on every
/// machine. Complexity: factor O(n w^2), solve O(n w), for a half width of w.
class BandedCholesky {
  public:
    BandedCholesky() = default;
    BandedCholesky(std::size_t size, std::size_t half_width);

    [[nodiscard]] std::size_t size() const { return size_; }
    /// Adds to element (i, j) and, if these differ, (j, i). Requires: |i - j| <= half width, not
    /// factored yet.
    void add(std::size_t i, std::size_t j, double value);
    /// False if the matrix is not positive definite.
    [[nodiscard]] bool factor();

    /// x = A^-1 x in place; V is a number, or a vector with += and a product with numbers.
    template <class V>
    void solve(V* x) const {
        for (std::size_t i = 0; i < size_; ++i) {
            for (std::size_t j = first(i); j < i; ++j) x[i] += -at(i, j) * x[j];
            x[i] = 1 / at(i, i) * x[i];
        }
        for (std::size_t i = size_; i-- > 0;) {
            x[i] = 1 / at(i, i) * x[i];
            for (std::size_t j = first(i); j < i; ++j) x[j] += -at(i, j) * x[i];
        }
    }

  private:
    [[nodiscard]] std::size_t first(std::size_t i) const { return i < width_ ? 0 : i - width_; }
    [[nodiscard]] double at(std::size_t i, std::size_t j) const {
        return rows_[i * (width_ + 1) + (i - j)];
    }
    [[nodiscard]] double& at(std::size_t i, std::size_t j) {
        return rows_[i * (width_ + 1) + (i - j)];
    }

    std::size_t size_ = 0;
    std::size_t width_ = 0;
    std::vector<double> rows_;  ///< row i: elements (i, i), (i, i - 1), ..
};

}  // namespace relief
