#pragma once

#include <optional>
#include <vector>

#include "edit/mesh_patch.h"

namespace relief::edit {

/// How changes of a depth spread to the finer ones. Keeps the patches that it needed: while the
/// points stay as they are, changes of the same vertices cost arithmetic only.
class MeshSpread {
  public:
    /// Must outlive this.
    explicit MeshSpread(const MeshLevels& levels)
        : levels_(&levels), patches_(static_cast<std::size_t>(levels.steps())) {}

    /// [depth]: from the given changes of `depth` on. points: [depth], before the change, the same
    /// at every call. Errors: those of MeshPatch.
    [[nodiscard]] Result<std::vector<std::vector<VertexChange>>> spread(
        const std::vector<MeshPoints>& points, int depth, std::vector<VertexChange> changes);

  private:
    [[nodiscard]] Result<std::vector<VertexChange>> spread_step(
        int step, const MeshPoints& points, std::span<const VertexChange> changes);

    const MeshLevels* levels_;
    std::vector<std::optional<MeshPatch>> patches_;  ///< [step]
};

}  // namespace relief::edit
