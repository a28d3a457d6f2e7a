#include "edit/plane_moves.h"

#include <limits>

#include "edit/cell_mesh.h"

namespace relief::edit {

using mesh::Index;

PlaneMoves::PlaneMoves(int levels)
    : sums_(static_cast<std::size_t>(levels) + 1), moved_(sums_.size()), changed_(sums_.size()) {}

PlaneMoves::Undo PlaneMoves::add(const std::vector<PointMove>& moves) {
    Undo undo;
    for (const PointMove& move : moves) {
        const auto level = static_cast<std::size_t>(move.level);
        const auto vertex = static_cast<Index>(move.point);
        const auto [found, is_new] = sums_[level].try_emplace(vertex);
        undo.entries.push_back(
            {move.level, vertex, is_new ? std::nullopt : std::optional(found->second)});
        VertexMove& sum = found->second;
        sum.delta += move.delta;
        sum.slope = sum.slope + move.slope;
        moved_[level].push_back(vertex);
    }
    return undo;
}

void PlaneMoves::restore(const Undo& undo) {
    for (auto entry = undo.entries.rbegin(); entry != undo.entries.rend(); ++entry) {
        const auto level = static_cast<std::size_t>(entry->level);
        if (entry->before)
            sums_[level][entry->vertex] = *entry->before;
        else
            sums_[level].erase(entry->vertex);
        moved_[level].push_back(entry->vertex);
    }
}

VertexMove PlaneMoves::at(int level, Index vertex) const {
    const auto& sums = sums_[static_cast<std::size_t>(level)];
    const auto found = sums.find(vertex);
    return found == sums.end() ? VertexMove{} : found->second;
}

void PlaneMoves::settle() {
    std::vector<Index> changed;
    for (int level = static_cast<int>(sums_.size()) - 1; level >= 0; --level) {
        const auto here = static_cast<std::size_t>(level);
        std::vector<Index>& moved = moved_[here];
        sort_unique(moved, std::numeric_limits<Index>::max());
        if (!changed.empty()) changed = children(level, changed);
        changed = merged(changed, moved);
        moved.clear();
        if (!changed.empty()) changed = update(level, changed);
        changed_[here] = merged(changed_[here], changed);
    }
}

std::vector<std::vector<Index>> PlaneMoves::take_changed() {
    std::vector<std::vector<Index>> changed(changed_.size());
    changed.swap(changed_);
    return changed;
}

}  // namespace relief::edit
