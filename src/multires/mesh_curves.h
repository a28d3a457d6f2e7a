#pragma once

#include <vector>

#include "relief/core/banded.h"
#include "relief/multires/mesh_step.h"

namespace relief::multires {

/// The curves of a step: boundaries and creases, whose vertices are fitted to the curve alone.
/// Source: reverse-subdivision.md sections 6.3 and 7.4.
class MeshCurves {
  public:
    explicit MeshCurves(const MeshStep<double>& step);

    [[nodiscard]] bool empty() const { return vertices_.empty(); }
    [[nodiscard]] const std::vector<mesh::Index>& vertices() const { return vertices_; }

    /// out[v] = the least squares solution over the curves' rows of the residual (old, fresh) for
    /// their vertices; others are left alone. Complexity: O(vertices of the curves).
    void fit(const Vec3<double>* old, const Vec3<double>* fresh, Vec3<double>* out) const;

  private:
    struct Weight {
        std::size_t vertex = 0;  ///< its place among `vertices_`
        double weight = 0;
    };
    /// A row of P on the curve: an old vertex, or a new one.
    struct Row {
        bool is_new = false;
        mesh::Index fine = 0;  ///< among the old or the new ones
        std::vector<Weight> weights;
    };

    void order_vertices(const MeshStep<double>& step);
    void add_dyadic_rows(const MeshStep<double>& step);
    void add_ternary_rows(const MeshStep<double>& step);
    void add_old_row(mesh::Index v, const rules::CurveRule& mask);
    void add_row(bool is_new, mesh::Index fine,
                 std::initializer_list<std::pair<mesh::Index, double>> weights);

    std::vector<mesh::Index> vertices_;               ///< neighbours on a curve are near each other
    std::vector<std::size_t> places_;                 ///< [vertex]; none: not on a curve, or fixed
    std::vector<std::array<mesh::Index, 2>> beside_;  ///< [vertex on a curve]: along it
    std::vector<Row> rows_;
    BandedCholesky normal_;
};

}  // namespace relief::multires
