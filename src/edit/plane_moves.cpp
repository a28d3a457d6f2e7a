#include "edit/plane_moves.h"

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
        std::vector<Index> affected;
        if (!changed.empty()) affected = children(level, changed);
        std::vector<Index>& moved = moved_[static_cast<std::size_t>(level)];
        affected.insert(affected.end(), moved.begin(), moved.end());
        moved.clear();
        sort_unique(affected);
        changed = affected.empty() ? affected : update(level, affected);
        auto& all = changed_[static_cast<std::size_t>(level)];
        all.insert(all.end(), changed.begin(), changed.end());
    }
}

std::vector<std::vector<Index>> PlaneMoves::take_changed() {
    std::vector<std::vector<Index>> changed(changed_.size());
    changed.swap(changed_);
    for (std::vector<Index>& level : changed) sort_unique(level);
    return changed;
}

}  // namespace relief::edit
