#include "edit/mesh_spread.h"

namespace relief::edit {

namespace {

/// Around what changes, at first; then a quarter more: the lift falls off by a half a ring.
constexpr int kRings = 8;

}  // namespace

Result<std::vector<VertexChange>> MeshSpread::spread_step(int step, const MeshPoints& points,
                                                          std::span<const VertexChange> changes) {
    if (changes.empty()) return std::vector<VertexChange>();
    std::optional<MeshPatch>& patch = patches_[static_cast<std::size_t>(step)];
    if (patch && patch->covers(changes)) {
        if (auto result = patch->spread(changes)) return *std::move(result);
    }
    for (int rings = patch ? patch->rings() : kRings;; rings += rings / 4) {
        RELIEF_TRY(patch, MeshPatch::create(*levels_, step, points, changes, rings));
        if (auto result = patch->spread(changes)) return *std::move(result);
    }
}

Result<std::vector<std::vector<VertexChange>>> MeshSpread::spread(
    const std::vector<MeshPoints>& points, int depth, std::vector<VertexChange> changes) {
    std::vector<std::vector<VertexChange>> all(points.size());
    all[static_cast<std::size_t>(depth)] = std::move(changes);
    for (int step = depth; step < levels_->steps(); ++step) {
        const auto k = static_cast<std::size_t>(step);
        RELIEF_TRY(all[k + 1], spread_step(step, points[k], all[k]));
    }
    return all;
}

}  // namespace relief::edit
