#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "edit/mesh_levels.h"
#include "edit/mesh_region.h"

namespace relief::edit {

/// A part of a depth, and the step from it to the next depth: what changes there when some of its
/// vertices change. All maps of a step are linear once details are turned, so that only the change
/// is synthesised.
class MeshPatch {
  public:
    /// The faces within `rings` rings around some vertices. points: of the depth, before the
    /// change. Errors: those of MeshHierarchy. Complexity: O(depth + patch).
    [[nodiscard]] static Result<MeshPatch> create(const MeshLevels& levels, int depth,
                                                  const MeshPoints& points,
                                                  std::span<const VertexChange> changes, int rings);

    [[nodiscard]] int rings() const { return rings_; }
    /// Whether what changes is well inside.
    [[nodiscard]] bool covers(std::span<const VertexChange> changes) const;
    /// What changes at the next depth, by more than the tolerance. Nothing: it reaches the cut, and
    /// more rings are needed. Requires: covers(changes). Complexity: O(patch) a sweep of the lift.
    [[nodiscard]] std::optional<std::vector<VertexChange>> spread(
        std::span<const VertexChange> changes) const;

  private:
    MeshPatch() = default;
    Status make_step(const MeshLevels& levels, int depth, MeshRegion& region);
    void name_fine(const MeshLevels& levels, int depth, const MeshRegion& region);
    void take_details(const MeshLevels& levels, int depth);
    void find_watched();

    int rings_ = 0;
    double tolerance_ = 0;
    bool has_cut_ = false;
    std::vector<mesh::Index> place_;  ///< [vertex of the depth]; kNone: not here
    std::vector<int> ring_;           ///< [vertex]
    std::unique_ptr<multires::MeshHierarchy> hierarchy_;
    multires::MeshMaps maps_;
    std::vector<mesh::Index> fine_;     ///< [fine vertex]: in the next depth; kNone: only here
    std::vector<mesh::Index> watched_;  ///< fine vertices near the cut
    multires::LocalDetails details_;
    MeshPoints coarse_;               ///< before the change,
    multires::GlobalDetails turned_;  ///< and the details there
};

}  // namespace relief::edit
