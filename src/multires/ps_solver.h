#pragma once

#include <Eigen/SparseCholesky>
#include <cstdint>
#include <optional>

#include "relief/multires/ps_energy.h"

namespace relief::multires::ps {

/// Solves with block matrices that are positive definite and have their blocks at the same places.
/// Same bits on every machine.
class Solver {
  public:
    explicit Solver(const BlockMatrix& pattern);

    /// Factors the matrix, its diagonal made 1 + shift times as large. Rows are scaled first, so
    /// that the diagonal is 1. If a pivot is not above 1e-13 afterwards, all that is left of it may
    /// be rounding: the result is the vertex of the first such pivot, and there are no factors.
    /// Complexity: O(n^1.5), memory O(n log n).
    [[nodiscard]] std::optional<mesh::Index> factor(const BlockMatrix& matrix, double shift = 0);

    /// Requires: factored. Complexity: O(n log n).
    [[nodiscard]] Coefficients solve(const Coefficients& right) const;

  private:
    using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int64_t>;
    [[nodiscard]] Matrix scaled_lower(const BlockMatrix& matrix) const;

    Eigen::VectorXd scale_;  ///< the inverse roots of the diagonal
    Eigen::SimplicialLDLT<Matrix, Eigen::Lower> factors_;
};

}  // namespace relief::multires::ps
