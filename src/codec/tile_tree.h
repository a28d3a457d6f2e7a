#pragma once

#include <cstdint>
#include <vector>

#include "relief/core/grid.h"

/// How a raster's lattices are cut into tiles. docs/codec.md, "Tiles".
namespace relief::codec {

/// Tiers: tier k is the lattice of every 8^k-th sample, cut into tiles of 512 x 512 of its samples
/// (the last of a row or column of tiles has 256 to 767). A tile holds three levels of its lattice,
/// 3k + 2 .. 3k; what is coarser it takes from tier k + 1. The top tier is one tile and holds all
/// coarser levels too.
class TileTree {
  public:
    static constexpr std::int64_t kTile = 512;
    static constexpr int kTierLevels = 3;

    /// Requires: 1 <= rows, cols < 2^31.
    TileTree(std::int64_t rows, std::int64_t cols);

    struct Tier {
        std::int64_t rows = 0;  ///< of its lattice
        std::int64_t cols = 0;
        std::int64_t tile_rows = 1;  ///< number of tiles
        std::int64_t tile_cols = 1;
        [[nodiscard]] std::int64_t tiles() const { return tile_rows * tile_cols; }
    };

    [[nodiscard]] int tiers() const { return static_cast<int>(tiers_.size()); }
    [[nodiscard]] const Tier& tier(int k) const { return tiers_[static_cast<std::size_t>(k)]; }
    /// The number of the coarsest level: its lattice has 2 samples or fewer a side, or the raster
    /// is one sample.
    [[nodiscard]] int levels() const { return levels_; }
    /// The tier that codes level l < levels(), and the coarsest level that it codes.
    [[nodiscard]] int tier_of(int level) const;
    [[nodiscard]] int coarsest_of(int tier) const;

    /// The samples of a tile, in the tier's lattice. Tiles are numbered row by row.
    [[nodiscard]] LatticeBox box(int tier, std::int64_t tile) const;
    /// Tiles of the tier that meet a box of its lattice: first and last row and column of tiles.
    [[nodiscard]] LatticeBox tiles_meeting(int tier, const LatticeBox& box) const;
    /// The tile of tier + 1 whose samples include the first one of `tile`.
    [[nodiscard]] std::int64_t parent(int tier, std::int64_t tile) const;

    /// All tiles of a tier along a Hilbert curve. Complexity: O(tiles log tiles).
    [[nodiscard]] std::vector<std::int64_t> hilbert_order(int tier) const;

    /// Number of tiles of all tiers.
    [[nodiscard]] std::int64_t tiles() const;

  private:
    std::vector<Tier> tiers_;
    int levels_ = 0;
};

/// ceil(n / 2^level): samples of a level along a side of n.
[[nodiscard]] inline std::int64_t level_size(std::int64_t n, int level) {
    return (n + (std::int64_t{1} << level) - 1) >> level;
}

/// The samples that a box of the raster has of a level's lattice.
[[nodiscard]] inline LatticeBox box_at_level(const LatticeBox& box, int level) {
    const std::int64_t row0 = level_size(box.row0, level);
    const std::int64_t col0 = level_size(box.col0, level);
    return {row0, col0, level_size(box.row0 + box.rows, level) - row0,
            level_size(box.col0 + box.cols, level) - col0};
}

}  // namespace relief::codec
