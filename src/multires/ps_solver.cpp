#include "multires/ps_solver.h"

#include <cmath>

namespace relief::multires::ps {

using mesh::Index;

namespace {

constexpr double kLost = 1e-13;

Eigen::VectorXd inverse_roots(const BlockMatrix& matrix) {
    Eigen::VectorXd roots(3 * static_cast<Eigen::Index>(matrix.rows()));
    for (Index v = 0; v < matrix.rows(); ++v)
        for (int j = 0; j < 3; ++j) {
            const double element = (*matrix.find(v, v))[4 * j];
            roots[3 * Eigen::Index{v} + j] = element > 0 ? 1 / std::sqrt(element) : 0;
        }
    return roots;
}

}  // namespace

Solver::Solver(const BlockMatrix& pattern) : scale_(inverse_roots(pattern)) {
    factors_.analyzePattern(scaled_lower(pattern));
}

std::optional<Index> Solver::factor(const BlockMatrix& matrix, double shift) {
    scale_ = inverse_roots(matrix);
    factors_.setShift(shift);
    factors_.factorize(scaled_lower(matrix));
    // There may be no pivots behind one that is lost.
    const auto& pivots = factors_.vectorD();
    for (Eigen::Index k = 0; k < pivots.size(); ++k)
        if (!(pivots[k] > kLost))
            return static_cast<Index>(factors_.permutationPinv().indices()[k] / 3);
    return std::nullopt;
}

Coefficients Solver::solve(const Coefficients& right) const {
    const Eigen::Map<const Eigen::VectorXd> b(right.data()->data(), scale_.size());
    Coefficients solution(right.size());
    Eigen::Map<Eigen::VectorXd> x(solution.data()->data(), scale_.size());
    x = factors_.solve(scale_.cwiseProduct(b));
    x.array() *= scale_.array();
    return solution;
}

Solver::Matrix Solver::scaled_lower(const BlockMatrix& matrix) const {
    Matrix lower(scale_.size(), scale_.size());
    lower.reserve(static_cast<Eigen::Index>(9 * (matrix.column.size() + matrix.rows()) / 2));
    for (Index v = 0; v < matrix.rows(); ++v)
        for (int l = 0; l < 3; ++l) {
            const Eigen::Index column = 3 * Eigen::Index{v} + l;
            lower.startVec(column);
            for (std::size_t at = matrix.first[v]; at < matrix.first[v + 1]; ++at)
                for (int j = 0; j < 3; ++j) {
                    const Eigen::Index row = 3 * Eigen::Index{matrix.column[at]} + j;
                    if (row >= column)
                        lower.insertBack(row, column) =
                            matrix.block[at][3 * l + j] * scale_[row] * scale_[column];
                }
        }
    lower.finalize();
    return lower;
}

}  // namespace relief::multires::ps
