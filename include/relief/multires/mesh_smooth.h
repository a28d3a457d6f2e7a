#pragma once

#include "relief/multires/mesh_step.h"

/// Smooth reverse subdivision: coarse meshes that give up some nearness for smoothness. Source:
/// reverse-subdivision.md section 7.5.
namespace relief::multires {

/// An invertible map of coarse vertices. c becomes the x that minimises
///     omega |P (x - c)|^2 + (1 - omega) |U x|^2
/// where U takes a vertex off the mean of its neighbours. If c is the least squares reversal of g,
/// whose residual is orthogonal to P, x also minimises omega |g - P x|^2 + (1 - omega) |U x|^2.
/// Boundaries and creases stay, and U looks at the other vertices only.
class MeshSmoothing {
  public:
    /// `step` must outlive this. Errors: InvalidArgument `invalid_parameter` unless omega is in
    /// (0, 1].
    [[nodiscard]] static Result<MeshSmoothing> create(const MeshStep<double>& step, double omega);

    /// In place. What P loses of some Catmull-Clark meshes (StiffVertices::alternating) becomes 0.
    /// Complexity: O(n) for each of some 50 to 150 rounds of conjugate gradients.
    void smooth(Vec3<double>* c) const;
    /// The reverse.
    void restore(Vec3<double>* c) const;

  private:
    MeshSmoothing(const MeshStep<double>& step, double omega);

    using Points = std::vector<Vec3<double>>;
    void keep_inner(Points& c) const;
    [[nodiscard]] Points nearness(const Points& c) const;
    [[nodiscard]] Points roughness(const Points& c) const;

    const MeshStep<double>* step_;
    double omega_;
    std::vector<double> shares_;  ///< [vertex]: of each neighbour in the mean; 0: U leaves it out
};

}  // namespace relief::multires
