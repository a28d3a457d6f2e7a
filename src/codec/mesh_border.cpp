#include "codec/mesh_border.h"

namespace relief::codec {

void MeshBorder::add_half_edges(std::span<const Corner> corners) {
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const Index from = corners[k].vertex;
        from_.push_back(from);
        to_.push_back(corners[(k + 1) % corners.size()].vertex);
        next_.push_back(mesh::kNone);
        prev_.push_back(mesh::kNone);
        open_.push_back(corners[k].glued ? 0 : 1);
        if (from >= degree_.size()) degree_.resize(std::size_t{from} + 1, 0);
        ++degree_[from];
    }
}

void MeshBorder::add_seed(std::span<const Corner> corners) {
    const auto first = static_cast<Index>(from_.size());
    add_half_edges(corners);
    const auto size = static_cast<Index>(corners.size());
    for (Index k = 0; k < size; ++k) link(first + (k + 1) % size, first + k);
}

/// At each corner the border that came to it goes on along the side before it, and the border along
/// the side behind it goes on as the border went on from there.
void MeshBorder::add_face(Index gate, std::span<const Corner> corners) {
    const auto first = static_cast<Index>(from_.size());
    const auto size = static_cast<Index>(corners.size());
    // What was there before.
    std::vector<Index> in(size, mesh::kNone);
    std::vector<Index> out(size, mesh::kNone);
    for (Index k = 0; k < size; ++k) {
        out[k] = corners[k].out;
        if (out[k] != mesh::kNone) in[k] = prev_[out[k]];
    }
    out[0] = gate;
    in[0] = prev_[gate];
    add_half_edges(corners);
    open_[first] = 0;
    for (Index k = 0; k < size; ++k)
        if (k == 0 || corners[k].glued) open_[out[k]] = 0;
    for (Index k = 0; k < size; ++k) {
        const Index before = (k + size - 1) % size;
        const bool open_before = before != 0 && !corners[before].glued;
        const bool open_behind = k != 0 && !corners[k].glued;
        if (out[k] == mesh::kNone) {
            link(first + k, first + before);
            continue;
        }
        if (open_before) link(in[k], first + before);
        if (open_behind) link(first + k, out[k]);
    }
}

}  // namespace relief::codec
