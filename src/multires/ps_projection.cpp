#include "multires/ps_projection.h"

#include <Eigen/SparseCholesky>

namespace relief::multires::ps {

using mesh::Index;

std::optional<Coefficients> solve(const BlockMatrix& gram, const Coefficients& right) {
    const auto size = static_cast<Eigen::Index>(3 * right.size());
    Eigen::SparseMatrix<double, Eigen::ColMajor, std::int64_t> lower(size, size);
    Eigen::VectorXd x(size);
    Eigen::Matrix<std::int64_t, Eigen::Dynamic, 1> entries(size);
    for (Index v = 0; v < right.size(); ++v)
        for (int j = 0; j < 3; ++j)
            entries[3 * Eigen::Index{v} + j] =
                static_cast<std::int64_t>(3 * gram.columns(v).size());
    lower.reserve(entries);
    for (Index v = 0; v < right.size(); ++v) {
        for (std::size_t at = gram.first[v]; at < gram.first[v + 1]; ++at) {
            if (gram.column[at] > v) continue;
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l) {
                    const Eigen::Index row = 3 * Eigen::Index{v} + j;
                    const Eigen::Index col = 3 * Eigen::Index{gram.column[at]} + l;
                    if (col <= row) lower.insert(row, col) = gram.block[at][3 * j + l];
                }
        }
        for (int j = 0; j < 3; ++j) x[3 * Eigen::Index{v} + j] = right[v][j];
    }
    const Eigen::SimplicialLDLT<decltype(lower), Eigen::Lower> factor(lower);
    if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 0)) return std::nullopt;
    x = factor.solve(x);
    Coefficients solution(right.size());
    for (Index v = 0; v < right.size(); ++v)
        for (int j = 0; j < 3; ++j) solution[v][j] = x[3 * Eigen::Index{v} + j];
    return solution;
}

}  // namespace relief::multires::ps
