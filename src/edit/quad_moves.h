#pragma once

#include "edit/cell_mesh.h"
#include "edit/plane_moves.h"
#include "relief/multires/fvs_mesh.h"

namespace relief::edit {

/// Moves of values: those of a level are added to the values that the coarser level's spline has at
/// its vertices, and the level's spline is the one through the sums, its derivatives estimated.
class QuadMoves final : public PlaneMoves {
  public:
    using Data = multires::fvs_mesh::NodalData;

    /// `meshes` are the levels from the finest. Both must outlive this.
    QuadMoves(const multires::fvs_mesh::Hierarchy& hierarchy, std::vector<const CellMesh*> meshes);

    /// What moves of `level` and coarser ones add. Requires: settled.
    [[nodiscard]] const Data& added(int level) const {
        return levels_[static_cast<std::size_t>(level)].data;
    }

  protected:
    [[nodiscard]] std::vector<mesh::Index> children(
        int level, const std::vector<mesh::Index>& parents) const override;
    [[nodiscard]] std::vector<mesh::Index> update(
        int level, const std::vector<mesh::Index>& vertices) override;

  private:
    using VertexQuadratic = multires::fvs_mesh::VertexQuadratic;
    struct Level {
        multires::fvs_mesh::LocalInterpolation local;
        Data data;
        std::vector<VertexQuadratic> quadratics;
        /// Of vertices near moves, or empty: a drag comes back to them.
        std::vector<multires::fvs_mesh::QuadraticRule> rules;
    };
    [[nodiscard]] const mesh::Quadrangulation& mesh(int level) const {
        return hierarchy_.mesh(hierarchy_.levels() - level);
    }
    [[nodiscard]] double value(int level, mesh::Index v) const;
    /// Sets values; returns the vertices at which they changed.
    [[nodiscard]] std::vector<mesh::Index> set_values(int level,
                                                      const std::vector<mesh::Index>& vertices);
    void keep_rules(Level& here, const std::vector<mesh::Index>& vertices);
    /// Sets quadratics; returns the vertices at which they changed.
    [[nodiscard]] std::vector<mesh::Index> set_quadratics(int level,
                                                          const std::vector<mesh::Index>& vertices);

    const multires::fvs_mesh::Hierarchy& hierarchy_;
    std::vector<const CellMesh*> meshes_;
    std::vector<Level> levels_;
    std::size_t kept_rules_ = 0;
};

}  // namespace relief::edit
