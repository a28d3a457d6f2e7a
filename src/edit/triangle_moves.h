#pragma once

#include <memory>

#include "edit/cell_mesh.h"
#include "edit/plane_moves.h"
#include "relief/multires/ps_lift.h"

namespace relief::edit {

/// Moves of control triangles: their coefficients are refined as those of the spline itself, by the
/// three rows of a vertex.
class TriangleMoves final : public PlaneMoves {
  public:
    using Components = std::vector<multires::ps::Coefficients>;

    /// One component moves by delta.z and slope, three by x, y and z. `meshes` are the levels from
    /// the finest. All must outlive this.
    TriangleMoves(const multires::ps::Hierarchy& hierarchy, std::vector<const CellMesh*> meshes,
                  std::size_t components);

    /// The coefficients that moves of `level` and coarser ones add. Requires: settled.
    [[nodiscard]] const Components& added(int level) const {
        return added_[static_cast<std::size_t>(level)];
    }

  protected:
    [[nodiscard]] std::vector<mesh::Index> children(
        int level, const std::vector<mesh::Index>& parents) const override;
    [[nodiscard]] std::vector<mesh::Index> update(
        int level, const std::vector<mesh::Index>& vertices) override;

  private:
    using Numbers = std::array<multires::ps::Heights, 3>;  ///< by component
    [[nodiscard]] int refined(int level) const { return hierarchy_.levels() - level; }
    [[nodiscard]] Numbers own(int level, mesh::Index v) const;
    [[nodiscard]] Numbers numbers(int level, mesh::Index v) const;

    const multires::ps::Hierarchy& hierarchy_;
    std::vector<const CellMesh*> meshes_;
    std::vector<Components> added_;
};

}  // namespace relief::edit
