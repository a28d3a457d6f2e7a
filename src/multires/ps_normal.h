#pragma once

#include <cstdint>
#include <vector>

#include "relief/core/block_cholesky.h"
#include "relief/multires/ps_fit.h"

/// Normal equations of splines over a triangulation, as blocks of the B-splines of two vertices.
namespace relief::multires::ps {

/// The graph of vertices that share a triangle; for jumps also those across an edge.
[[nodiscard]] mesh::VertexStars coupling(const mesh::Triangulation& mesh, Energy energy);

[[nodiscard]] inline GraphView graph_of(const mesh::VertexStars& stars) {
    return {stars.first, stars.items};
}

/// A symmetric matrix over the coefficients, with blocks where `graph` has edges.
struct NormalMatrix {
    std::vector<Block3> diagonal;
    std::vector<Block3> off_diagonal;  ///< parallel to the graph's items

    NormalMatrix() = default;
    explicit NormalMatrix(const mesh::VertexStars& graph)
        : diagonal(graph.first.size() - 1, Block3{}), off_diagonal(graph.items.size(), Block3{}) {}

    /// Adds a matrix over the nine coefficients of three vertices.
    void add(const mesh::VertexStars& graph, const std::array<mesh::Index, 3>& vertices,
             const spline::PsMatrix& matrix);
    /// Adds factor f f^T for a functional f of `count` vertices.
    void add_square(const mesh::VertexStars& graph, const mesh::Index* vertices, std::size_t count,
                    const Column3* functional, double factor);
};

/// a + factor b.
[[nodiscard]] NormalMatrix combined(const NormalMatrix& a, double factor, const NormalMatrix& b);

/// The energy of a spline as c^T (matrix) c.
[[nodiscard]] NormalMatrix energy_matrix(const Space& space, const mesh::VertexStars& graph,
                                         Energy energy);

/// Data by triangles. The values of the nine B-splines there are quadratics on each of six pieces.
class SortedSites {
  public:
    SortedSites(const Space& space, const DataSites& sites);

    [[nodiscard]] std::size_t size() const { return point_.size(); }
    [[nodiscard]] double total_weight() const { return total_weight_; }
    [[nodiscard]] double weight(std::size_t point) const {
        return weights_.empty() ? 1 : weights_[point];
    }

    /// The sum of w row row^T.
    [[nodiscard]] NormalMatrix normal_matrix(const mesh::VertexStars& graph) const;
    /// out = sum of factors[point] row for each of `count` factors a point.
    void adjoint(std::span<const double> factors, std::size_t count,
                 std::span<std::vector<Column3>> out) const;
    /// Values of a spline.
    void evaluate(std::span<const Heights> spline, std::span<double> out) const;

  private:
    /// Row of a point of a triangle whose basis functions are given.
    using BasisPolynomials = std::array<spline::PsPolynomials, 9>;
    [[nodiscard]] BasisPolynomials basis_of(mesh::Index t) const;
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
