#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "codec/dense_kernels.h"
#include "codec/dense_tables.h"

namespace relief::codec::dense {

static_assert(kUnknowns == kFeatures);
using Weights = std::array<double, kFeatures>;

/// Weighted least squares with a ridge towards a start: minimises the sum over equations of
/// weight (target - w . features)^2 plus r |w - start|^2, r as kLearning says. The absolute ridge
/// keeps the weights in place where predictions are never corrected: a decoder would learn its own
/// predictions there.
class RidgeRegression {
  public:
    explicit RidgeRegression(const Weights& start) : start_(start), weights_(start) {}

    [[nodiscard]] const Weights& weights() const { return weights_; }

    /// Adds equations, and solves when enough have come in to matter.
    void learn(std::span<const Equation> equations) {
        add_equations(equations, normal_);
        added_ += equations.size();
        if (added_ < kLearning.batch) return;
        added_ = 0;
        solve();
    }

    /// Makes what was learnt so far count less.
    void fade() {
        for (Weights& row : normal_)
            for (double& element : row) element *= kLearning.fade;
    }

  private:
    static constexpr double kLeastPivot = 1e-12;

    /// By Cholesky's decomposition.
    void solve() {
        constexpr std::size_t n = kFeatures;
        double trace = 0;
        for (std::size_t i = 0; i < n; ++i) trace += normal_[i][i];
        const double ridge = kLearning.trace_ridge * trace / n + kLearning.ridge;
        std::array<Weights, n> lower;
        Weights solution;
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j <= i; ++j) {
                double sum = normal_[i][j] + (i == j ? ridge : 0);
                for (std::size_t k = 0; k < j; ++k) sum -= lower[i][k] * lower[j][k];
                lower[i][j] = i == j ? std::sqrt(std::max(sum, kLeastPivot)) : sum / lower[j][j];
            }
            double sum = normal_[n][i] + ridge * start_[i];
            for (std::size_t k = 0; k < i; ++k) sum -= lower[i][k] * solution[k];
            solution[i] = sum / lower[i][i];
        }
        for (std::size_t i = n; i-- > 0;) {
            double sum = solution[i];
            for (std::size_t k = i + 1; k < n; ++k) sum -= lower[k][i] * solution[k];
            solution[i] = sum / lower[i][i];
        }
        weights_ = solution;
    }

    Weights start_;
    Weights weights_;
    NormalEquations normal_ = {};
    std::size_t added_ = 0;
};

}  // namespace relief::codec::dense
