#include "multires/ps_rings.h"

#include <algorithm>

namespace relief::multires::ps {

using mesh::Index;
using mesh::kNone;

/// Whether v is new. A first ring may be of any size; only what comes with it to less than `enough`
/// points is looked up, so that the table never fills.
bool StencilSearch::mark(Index v) {
    std::size_t slot = (v * std::uint64_t{0x9E3779B97F4A7C15}) >> 52;
    while (slots_[slot] != kNone) {
        if (slots_[slot] == v) return false;
        slot = (slot + 1) % kSlots;
    }
    slots_[slot] = v;
    used_.push_back(slot);
    return true;
}

std::span<const Index> StencilSearch::rings(Index v, std::size_t enough) {
    const auto first = neighbours_.of(v);
    found_.assign(first.begin(), first.end());
    if (found_.size() >= enough) return found_;
    mark(v);
    for (const Index w : first) mark(w);
    std::size_t begin = 0;
    for (int ring = 1; ring < kMostRings && found_.size() < enough; ++ring) {
        const std::size_t end = found_.size();
        for (; begin < end; ++begin) {
            const auto around = neighbours_.of(found_[begin]);
            if (around.size() > kMostSpokes) continue;
            for (const Index w : around)
                if (mark(w)) found_.push_back(w);
        }
        if (found_.size() == end) break;
    }
    for (const std::size_t slot : used_) slots_[slot] = kNone;
    used_.clear();
    return found_;
}

std::span<const Index> StencilSearch::nearest(Index v, std::size_t enough, std::size_t most) {
    const auto all = rings(v, enough);
    if (all.size() <= most) return all;
    sorted_.clear();
    for (const Index w : all) {
        const Vec2 d = mesh_.vertex(w) - mesh_.vertex(v);
        sorted_.push_back({dot(d, d), w});
    }
    const auto end = sorted_.begin() + static_cast<std::ptrdiff_t>(most);
    std::nth_element(sorted_.begin(), end, sorted_.end());
    std::sort(sorted_.begin(), end);
    found_.clear();
    for (auto nearest = sorted_.begin(); nearest != end; ++nearest)
        found_.push_back(nearest->vertex);
    return found_;
}

}  // namespace relief::multires::ps
