#pragma once

#include <optional>

#include "multires/small_cholesky.h"
#include "relief/multires/ps_energy.h"
#include "relief/multires/ps_lift.h"

/// The local systems of the update. Private to the module.
namespace relief::multires::ps {

/// What the systems of a level are made of.
struct LevelProducts {
    LevelProducts(const Space& coarse, const Refinement& step);

    const Space& coarse;
    const Refinement& step;
    BlockMatrix coarse_gram;
    BlockMatrix fine_gram;
    std::vector<std::array<Moments, 3>> coarse_moments;
    std::vector<std::array<Moments, 3>> fine_moments;
    std::vector<StepRows> rows;    ///< of each fine vertex
    mesh::VertexStars neighbours;  ///< in the coarse mesh

    /// A stencil for each coarse triangle, then for each coarse edge.
    [[nodiscard]] std::size_t stencils() const {
        return coarse.mesh.triangles.size() + coarse.mesh.edges.size();
    }
};

/// The coarse vertices that the details of one triangle or edge may change, and the system that
/// says by how much. Linear in the details.
class UpdateStencil {
  public:
    /// Requires: an update that has stencils, which None and Full have not.
    UpdateStencil(const LevelProducts& level, std::size_t stencil, Update update);

    /// False if a system is singular; then nothing else may be called.
    [[nodiscard]] bool solvable() const { return solvable_; }
    [[nodiscard]] const std::vector<mesh::Index>& vertices() const { return vertices_; }
    /// The fine vertices whose details count here.
    [[nodiscard]] mesh::Index first_new() const { return first_new_; }
    [[nodiscard]] mesh::Index new_count() const { return new_count_; }

    /// What the details of the stencil's new vertices add to the coefficients of vertices(), three
    /// numbers each.
    [[nodiscard]] std::vector<double> increments(std::span<const Heights> details) const;
    /// The squared L2 norm of the wavelet of these details.
    [[nodiscard]] double squared_norm(std::span<const Heights> details,
                                      const std::vector<double>& increments) const;

  private:
    [[nodiscard]] std::vector<double> products(std::span<const Heights> details) const;
    void build_gram();
    void build_moments();
    [[nodiscard]] std::array<double, 3> scaled(const Moments& moments, Vec2 vertex) const;
    [[nodiscard]] std::array<double, 3> missing_moments(std::span<const Heights> details,
                                                        const std::vector<double>& u) const;

    const LevelProducts& level_;
    bool solvable_ = true;
    mesh::Index first_new_ = 0;
    mesh::Index new_count_ = 0;
    std::vector<mesh::Index> vertices_;  ///< ascending
    Vec2 centre_;
    double size_ = 1;
    std::vector<double> gram_;
    std::optional<SmallCholesky> system_;        ///< of gram_; not for Moments
    std::vector<std::array<double, 3>> moment_;  ///< of each coarse function; empty without moments
    std::vector<std::array<double, 3>> correction_;  ///< Y: what a moment of 1 adds to it
    std::optional<SmallCholesky> moment_system_;
};

}  // namespace relief::multires::ps
