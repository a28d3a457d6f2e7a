#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

namespace relief::multires {

/// Solves small symmetric positive definite systems: A = S L L^T S with S the roots of A's
/// diagonal. Plain loops, so that results have the same bits everywhere.
class SmallCholesky {
  public:
    /// `a` has n x n entries, of which the lower triangle is read. Nothing if a pivot of the scaled
    /// matrix (1 minus the squared correlation of an unknown with those before it) is not above
    /// `smallest_pivot`.
    static std::optional<SmallCholesky> factor(std::vector<double> a, std::size_t n,
                                               double smallest_pivot) {
        SmallCholesky c{std::move(a), n};
        c.scale_.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            if (!(c.at(i, i) > 0)) return std::nullopt;
            c.scale_[i] = 1 / std::sqrt(c.at(i, i));
        }
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j <= i; ++j) {
                double sum = c.at(i, j) * c.scale_[i] * c.scale_[j];
                for (std::size_t k = 0; k < j; ++k) sum -= c.at(i, k) * c.at(j, k);
                if (i == j && !(sum > smallest_pivot)) return std::nullopt;
                c.at(i, j) = i == j ? std::sqrt(sum) : sum / c.at(j, j);
            }
        return c;
    }

    /// Replaces the right-hand side of n numbers by the solution.
    void solve(double* x) const {
        for (std::size_t i = 0; i < n_; ++i) {
            double sum = x[i] * scale_[i];
            for (std::size_t k = 0; k < i; ++k) sum -= at(i, k) * x[k];
            x[i] = sum / at(i, i);
        }
        for (std::size_t i = n_; i-- > 0;) {
            double sum = x[i];
            for (std::size_t k = i + 1; k < n_; ++k) sum -= at(k, i) * x[k];
            x[i] = sum / at(i, i);
        }
        for (std::size_t i = 0; i < n_; ++i) x[i] *= scale_[i];
    }

  private:
    SmallCholesky(std::vector<double> a, std::size_t n) : a_(std::move(a)), n_(n) {}
    double& at(std::size_t i, std::size_t j) { return a_[i * n_ + j]; }
    [[nodiscard]] const double& at(std::size_t i, std::size_t j) const { return a_[i * n_ + j]; }

    std::vector<double> a_;
    std::size_t n_;
    std::vector<double> scale_;
};

}  // namespace relief::multires
