#include "codec/tile_tree.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace relief::codec {

namespace {

/// A rest of less than half a tile joins the tile before it.
std::int64_t tile_count(std::int64_t n) {
    return std::max<std::int64_t>(1, (n + TileTree::kTile / 2) / TileTree::kTile);
}

/// The tile, of `count`, that holds sample x; the first or last one for samples beyond them.
std::int64_t tile_of(std::int64_t x, std::int64_t count) {
    return std::clamp<std::int64_t>(x / TileTree::kTile, 0, count - 1);
}

/// Place of (row, col) on the Hilbert curve through a square of 2^order cells a side.
std::uint64_t hilbert_index(std::uint64_t row, std::uint64_t col, int order) {
    std::uint64_t index = 0;
    for (int bit = order - 1; bit >= 0; --bit) {
        const std::uint64_t x = col >> bit & 1;
        const std::uint64_t y = row >> bit & 1;
        index = index << 2 | ((3 * x) ^ y);
        if (y == 0) {
            const std::uint64_t all = (std::uint64_t{1} << bit) - 1;
            if (x == 1) {
                row = all - (row & all);
                col = all - (col & all);
            }
            std::swap(row, col);
        }
    }
    return index;
}

}  // namespace

TileTree::TileTree(std::int64_t rows, std::int64_t cols) {
    do {
        tiers_.push_back({rows, cols, tile_count(rows), tile_count(cols)});
        rows = level_size(rows, kTierLevels);
        cols = level_size(cols, kTierLevels);
    } while (tiers_.back().tiles() > 1);
    const auto largest =
        static_cast<std::uint64_t>(std::max(tiers_.back().rows, tiers_.back().cols));
    // ceil(log2(largest)) - 1 levels leave two samples.
    const int above = largest <= 2 ? 0 : static_cast<int>(std::bit_width(largest - 1)) - 1;
    levels_ = kTierLevels * (tiers() - 1) + above;
}

int TileTree::tier_of(int level) const {
    return std::min(level / kTierLevels, tiers() - 1);
}

int TileTree::coarsest_of(int tier) const {
    return tier == tiers() - 1 ? levels_ - 1 : kTierLevels * tier + kTierLevels - 1;
}

LatticeBox TileTree::box(int k, std::int64_t tile) const {
    const Tier& t = tier(k);
    const std::int64_t i = tile / t.tile_cols;
    const std::int64_t j = tile % t.tile_cols;
    const std::int64_t row_end = i == t.tile_rows - 1 ? t.rows : (i + 1) * kTile;
    const std::int64_t col_end = j == t.tile_cols - 1 ? t.cols : (j + 1) * kTile;
    return {i * kTile, j * kTile, row_end - i * kTile, col_end - j * kTile};
}

LatticeBox TileTree::tiles_meeting(int k, const LatticeBox& box) const {
    const Tier& t = tier(k);
    const std::int64_t row0 = tile_of(box.row0, t.tile_rows);
    const std::int64_t col0 = tile_of(box.col0, t.tile_cols);
    return {row0, col0, tile_of(box.row0 + box.rows - 1, t.tile_rows) - row0 + 1,
            tile_of(box.col0 + box.cols - 1, t.tile_cols) - col0 + 1};
}

std::int64_t TileTree::parent(int k, std::int64_t tile) const {
    const LatticeBox inside = box(k, tile);
    const Tier& above = tier(k + 1);
    return tile_of(inside.row0 >> kTierLevels, above.tile_rows) * above.tile_cols +
           tile_of(inside.col0 >> kTierLevels, above.tile_cols);
}

std::vector<std::int64_t> TileTree::hilbert_order(int k) const {
    const Tier& t = tier(k);
    const int order = static_cast<int>(
        std::bit_width(static_cast<std::uint64_t>(std::max(t.tile_rows, t.tile_cols) - 1)));
    std::vector<std::pair<std::uint64_t, std::int64_t>> keyed;
    keyed.reserve(static_cast<std::size_t>(t.tiles()));
    for (std::int64_t tile = 0; tile < t.tiles(); ++tile)
        keyed.emplace_back(hilbert_index(static_cast<std::uint64_t>(tile / t.tile_cols),
                                         static_cast<std::uint64_t>(tile % t.tile_cols), order),
                           tile);
    std::sort(keyed.begin(), keyed.end());
    std::vector<std::int64_t> tiles;
    tiles.reserve(keyed.size());
    for (const auto& [key, tile] : keyed) tiles.push_back(tile);
    return tiles;
}

std::int64_t TileTree::tiles() const {
    std::int64_t sum = 0;
    for (const Tier& t : tiers_) sum += t.tiles();
    return sum;
}

}  // namespace relief::codec
