#include "codec/ps_surroundings.h"

#include <algorithm>

namespace relief::codec {

using mesh::Index;

PsSurroundings::PsSurroundings(const mesh::Triangulation& mesh)
    : mesh_(mesh),
      neighbours_(vertex_neighbours(mesh)),
      known_(mesh.x.size()),
      seen_from_(mesh.x.size(), mesh::kNone) {}

void PsSurroundings::see_neighbours(Index v) {
    const auto all = neighbours_.of(v);
    for (const Index u : all.first(std::min(all.size(), kMostSpokes))) {
        if (seen_from_[u] == searching_) continue;
        seen_from_[u] = searching_;
        ring_.push_back(u);
        if (known_[u] != 0 && around_.size() < kMost) around_.push_back(u);
    }
}

/// Whole rings until enough known vertices are met.
void PsSurroundings::find(Index v, Index stride) {
    around_.clear();
    if (stride > kLargestSearched || stride == 0) return find_along_order(v, stride);
    searching_ = v;
    seen_from_[v] = v;
    ring_.assign(1, v);
    for (std::size_t begin = 0; begin < ring_.size() && around_.size() < kEnough;) {
        const std::size_t end = ring_.size();
        for (; begin < end && ring_.size() < kMostSeen; ++begin) see_neighbours(ring_[begin]);
        if (ring_.size() >= kMostSeen) return;
    }
}

void PsSurroundings::find_along_order(Index v, Index stride) {
    if (stride == 0) return;
    for (const Index steps : {1U, 3U, 5U}) {
        const std::uint64_t reach = std::uint64_t{steps} * stride;
        if (reach <= v) around_.push_back(static_cast<Index>(v - reach));
        if (v + reach < mesh_.x.size()) around_.push_back(static_cast<Index>(v + reach));
    }
}

}  // namespace relief::codec
