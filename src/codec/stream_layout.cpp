#include "codec/stream_layout.h"

#include <algorithm>
#include <limits>

namespace relief::codec {

namespace {

using Group = StreamLayout::Group;

/// Levels of the top tier share a stream while the raster that they give has at most so many
/// samples.
constexpr std::int64_t kSharedSamples = std::int64_t{1} << 15;
/// Borders of the lattices of bands that reach over the raster.
constexpr std::int64_t kFar = std::int64_t{1} << 40;

int tier_of(const TileTree& tree, int level) {
    return std::min(std::max(level - 1, 0) / TileTree::kTierLevels, tree.tiers() - 1);
}

std::vector<Group> groups_of(const multires::PyramidLayout& layout, const TileTree& tree) {
    std::vector<Group> groups;
    for (int level = layout.levels(); level >= std::min(1, layout.levels()); --level) {
        const int tier = tier_of(tree, level);
        const int below = std::max(level - 1, 0);
        const bool shared =
            !groups.empty() && tree.tier(tier).tiles() == 1 &&
            level_size(layout.rows, below) * level_size(layout.cols, below) <= kSharedSamples;
        if (shared) {
            groups.back().finest = level;
            continue;
        }
        const std::size_t first = groups.empty() ? 0 : groups.back().first + groups.back().count;
        groups.push_back(
            {tier, level, level, first, static_cast<std::size_t>(tree.tier(tier).tiles())});
    }
    return groups;
}

}  // namespace

StreamLayout::StreamLayout(const multires::PyramidLayout& layout)
    : layout_(layout), tree_(layout.rows, layout.cols), groups_(groups_of(layout, tree_)) {
    orders_.resize(static_cast<std::size_t>(tree_.tiers()));
    for (const Group& group : groups_) {
        Order& order = orders_[static_cast<std::size_t>(group.tier)];
        if (!order.tiles.empty()) continue;
        order.tiles = tree_.hilbert_order(group.tier);
        order.places.resize(order.tiles.size());
        for (std::size_t k = 0; k < order.tiles.size(); ++k)
            order.places[static_cast<std::size_t>(order.tiles[k])] = k;
    }
}

std::uint64_t StreamLayout::count(const multires::PyramidLayout& layout) {
    const std::vector<Group> groups = groups_of(layout, TileTree(layout.rows, layout.cols));
    return std::uint64_t{groups.back().first} + groups.back().count;
}

std::size_t StreamLayout::group_of(std::size_t stream) const {
    std::size_t k = 0;
    while (stream >= groups_[k].first + groups_[k].count) ++k;
    return k;
}

std::size_t StreamLayout::group_of_level(int level) const {
    std::size_t k = 0;
    while (groups_[k].finest > level) ++k;
    return k;
}

std::int64_t StreamLayout::tile(const Group& group, std::size_t stream) const {
    return orders_[static_cast<std::size_t>(group.tier)].tiles[stream - group.first];
}

std::size_t StreamLayout::stream(const Group& group, std::int64_t tile) const {
    return group.first +
           orders_[static_cast<std::size_t>(group.tier)].places[static_cast<std::size_t>(tile)];
}

std::optional<std::size_t> StreamLayout::parent(std::size_t number) const {
    const std::size_t k = group_of(number);
    if (k == 0) return {};
    const Group& group = groups_[k];
    const Group& above = groups_[k - 1];
    const std::int64_t here = tile(group, number);
    return stream(above, above.tier == group.tier ? here : tree_.parent(group.tier, here));
}

/// Tiles at the border take what bands have beyond it.
LatticeBox StreamLayout::range(int tier, std::int64_t number, int level) const {
    const TileTree::Tier& t = tree_.tier(tier);
    const int shift = level - TileTree::kTierLevels * tier;
    const auto bound = [&](std::int64_t place, std::int64_t places) {
        if (place == 0) return -kFar;
        return place == places ? kFar : place * TileTree::kTile >> shift;
    };
    const std::int64_t i = number / t.tile_cols;
    const std::int64_t j = number % t.tile_cols;
    const std::int64_t row0 = bound(i, t.tile_rows);
    const std::int64_t col0 = bound(j, t.tile_cols);
    return {row0, col0, bound(i + 1, t.tile_rows) - row0, bound(j + 1, t.tile_cols) - col0};
}

std::vector<BandPart> StreamLayout::parts(std::size_t stream) const {
    const Group& group = groups_[group_of(stream)];
    const std::int64_t number = tile(group, stream);
    std::vector<BandPart> parts;
    for (std::size_t k = 0; k < layout_.bands.size(); ++k) {
        const multires::BandLayout& band = layout_.bands[k];
        if (band.level > group.coarsest || band.level < group.finest) continue;
        parts.push_back({k, intersection(band.box, range(group.tier, number, band.level))});
    }
    return parts;
}

std::vector<std::size_t> StreamLayout::meeting(std::size_t group, int level,
                                               const LatticeBox& box) const {
    const Group& g = groups_[group];
    const int shift = level - TileTree::kTierLevels * g.tier;
    const LatticeBox tiles = tree_.tiles_meeting(
        g.tier, {box.row0 << shift, box.col0 << shift, box.rows << shift, box.cols << shift});
    std::vector<std::size_t> met;
    for (std::int64_t i = tiles.row0; i < tiles.row0 + tiles.rows; ++i)
        for (std::int64_t j = tiles.col0; j < tiles.col0 + tiles.cols; ++j) {
            const std::int64_t number = i * tree_.tier(g.tier).tile_cols + j;
            if (intersection(range(g.tier, number, level), box).count() != 0)
                met.push_back(stream(g, number));
        }
    std::sort(met.begin(), met.end());
    return met;
}

LatticeBox StreamLayout::samples(std::size_t stream) const {
    const Group& group = groups_[group_of(stream)];
    const int bits = TileTree::kTierLevels * group.tier;
    const LatticeBox box = tree_.box(group.tier, tile(group, stream));
    return intersection({box.row0 << bits, box.col0 << bits, box.rows << bits, box.cols << bits},
                        {0, 0, layout_.rows, layout_.cols});
}

}  // namespace relief::codec
