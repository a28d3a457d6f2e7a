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
            for (std::size_t j = 0; j <= i; ++j)
                c.at(i, j) = c.at(i, j) * c.scale_[i] * c.scale_[j];
        // Column by column. Each takes its part from all that follow at once, which the compiler
        // can do several at a time, unlike sums.
        std::vector<double> column(n);
        for (std::size_t k = 0; k < n; ++k) {
            if (!(c.at(k, k) > smallest_pivot)) return std::nullopt;
            c.at(k, k) = std::sqrt(c.at(k, k));
            for (std::size_t i = k + 1; i < n; ++i) column[i] = c.at(i, k) /= c.at(k, k);
            for (std::size_t i = k + 1; i < n; ++i) {
                double* row = &c.at(i, 0);
                const double factor = row[k];
                for (std::size_t j = k + 1; j <= i; ++j) row[j] -= factor * column[j];
            }
        }
        return c;
    }

    /// Replaces the right-hand side of n numbers by the solution; or kSides of them at once, which
    /// takes hardly longer: number i of side s is x[kSides i + s].
    template <std::size_t kSides = 1>
    void solve(double* x) const {
        double sum[kSides];
        const auto take = [&](double weight, std::size_t k) {
            for (std::size_t s = 0; s < kSides; ++s) sum[s] -= weight * x[kSides * k + s];
        };
        for (std::size_t i = 0; i < n_; ++i) {
            for (std::size_t s = 0; s < kSides; ++s) sum[s] = x[kSides * i + s] * scale_[i];
            for (std::size_t k = 0; k < i; ++k) take(at(i, k), k);
            for (std::size_t s = 0; s < kSides; ++s) x[kSides * i + s] = sum[s] / at(i, i);
        }
        for (std::size_t i = n_; i-- > 0;) {
            for (std::size_t s = 0; s < kSides; ++s) sum[s] = x[kSides * i + s];
            for (std::size_t k = i + 1; k < n_; ++k) take(at(k, i), k);
            for (std::size_t s = 0; s < kSides; ++s) x[kSides * i + s] = sum[s] / at(i, i);
        }
        for (std::size_t i = 0; i < kSides * n_; ++i) x[i] *= scale_[i / kSides];
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
