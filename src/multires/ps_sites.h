#pragma once

#include <cstdint>
#include <vector>

#include "multires/ps_triangles.h"
#include "relief/multires/ps_energy.h"
#include "relief/multires/ps_fit.h"

/// Places of data on a triangulation.
namespace relief::multires::ps {

/// Data by triangles. The values of the nine B-splines there are quadratics on each of six pieces.
class SortedSites {
  public:
    SortedSites(const Space& space, const DataSites& sites);

    [[nodiscard]] std::size_t size() const { return point_.size(); }
    [[nodiscard]] double total_weight() const { return total_weight_; }
    [[nodiscard]] double weight(std::size_t point) const {
        return weights_.empty() ? 1 : weights_[point];
    }

    /// The sum of w b b^T, b being the values of all B-splines at a point. `coupled` joins at least
    /// vertices with a common edge.
    [[nodiscard]] BlockMatrix normal_matrix(const mesh::VertexStars& coupled) const;
    /// out[s] = the sum of factors[count * point + s] b, for each s below `count`.
    [[nodiscard]] std::vector<Coefficients> adjoint(std::span<const double> factors,
                                                    std::size_t count) const;
    /// Values of a spline.
    void evaluate(std::span<const Heights> spline, std::span<double> out) const;

  private:
    /// The values of a triangle's B-splines at the k-th sorted point, which it contains.
    [[nodiscard]] std::array<double, 9> row(const BasisPolynomials& basis, std::size_t k) const;

    const Space& space_;
    std::vector<std::uint64_t> first_;  ///< of each triangle among the sorted points
    std::vector<std::uint64_t> point_;  ///< the number of each sorted point
    std::vector<Vec2> offset_;          ///< of each sorted point from Z
    std::vector<std::uint8_t> piece_;
    std::vector<double> weights_;  ///< of each point, not sorted; empty: all 1
    double total_weight_ = 0;
};

}  // namespace relief::multires::ps
