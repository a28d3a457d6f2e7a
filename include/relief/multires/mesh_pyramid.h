#pragma once

#include <memory>
#include <span>
#include <vector>

#include "relief/multires/mesh_hierarchy.h"

/// A mesh as its coarsest mesh and details: reverse subdivision in memory. Source:
/// reverse-subdivision.md sections 6, 7 and 9.
namespace relief::multires {

/// Coefficients of a mesh that is the subdivision of a coarser one. Level 0 is the mesh itself;
/// each level above is one step coarser. Vertices of all levels have the numbers of the hierarchy,
/// in which those of a level are the first ones of the level below.
class MeshPyramid {
  public:
    /// Goes down as many steps as the mesh has and `most` allows. Errors: those of origin_of,
    /// MeshHierarchy::create and MeshMaps::create; BadInput `non_finite_vertex`. Complexity: O(n) a
    /// sweep.
    [[nodiscard]] static Result<MeshPyramid> analyse(const mesh::Topology& mesh,
                                                     std::span<const Vec3<double>> points,
                                                     const MeshTags& tags, MeshScheme scheme,
                                                     int most, const MeshTransform& transform);

    [[nodiscard]] const MeshHierarchy& hierarchy() const { return *hierarchy_; }
    [[nodiscard]] int levels() const { return hierarchy_->steps(); }
    [[nodiscard]] const mesh::Topology& topology(int level) const {
        return hierarchy_->topology(levels() - level);
    }

    /// Places of the coarsest vertices, then the details of level levels() - 1 (those of the
    /// vertices that it adds), .., 0. May be changed.
    [[nodiscard]] std::span<Vec3<double>> coefficients() { return coefficients_; }
    [[nodiscard]] std::span<const Vec3<double>> coefficients() const { return coefficients_; }
    /// Which of them belong to a level: its details, or for levels() the coarsest vertices.
    [[nodiscard]] std::span<Vec3<double>> band(int level);

    /// For each vertex of level 0 its number in the mesh that was analysed.
    [[nodiscard]] const std::vector<mesh::Index>& numbers() const { return numbers_; }

    /// The vertices of a level that the coefficients give. Requires: 0 <= level <= levels().
    /// Complexity: O(n) a sweep.
    [[nodiscard]] std::vector<Vec3<double>> synthesise(int level = 0) const;

  private:
    // On the heap: maps refer to the hierarchy.
    std::unique_ptr<MeshHierarchy> hierarchy_;
    std::unique_ptr<MeshMaps> maps_;
    std::vector<Vec3<double>> coefficients_;
    StiffResiduals residuals_;
    std::vector<mesh::Index> numbers_;
};

}  // namespace relief::multires
