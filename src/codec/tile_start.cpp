#include "codec/tile_start.h"

#include <algorithm>

namespace relief::codec {

namespace {

/// Margin cells that predictors of the next level can reach.
constexpr std::int64_t kReach = 3;

}  // namespace

TileState state_below(const LatticeCoding& coding, const TileTree& tree, int tier,
                      std::int64_t tile, const std::vector<std::unique_ptr<LevelCodec>>& learnt,
                      const FetchSamples& fetch) {
    const LatticeBox box = tree.box(tier, tile);
    const TileTree::Tier& all = tree.tier(tier);
    const TileTree::Tier& above = tree.tier(tier + 1);
    const LatticeBox inside{box.row0 >> TileTree::kTierLevels, box.col0 >> TileTree::kTierLevels,
                            level_size(box.rows, TileTree::kTierLevels),
                            level_size(box.cols, TileTree::kTierLevels)};
    const std::int64_t row0 = std::max<std::int64_t>(0, inside.row0 - kReach);
    const std::int64_t col0 = std::max<std::int64_t>(0, inside.col0 - kReach);
    const std::int64_t row1 = std::min(above.rows, inside.row0 + inside.rows + kReach);
    const std::int64_t col1 = std::min(above.cols, inside.col0 + inside.cols + kReach);
    TileState state;
    for (std::size_t c = 0; c < coding.domains.size(); ++c) {
        LatticeLevel level;
        level.level = TileTree::kTierLevels * (tier + 1);
        level.borders = {box.row0 == 0, box.row0 + box.rows == all.rows, box.col0 == 0,
                         box.col0 + box.cols == all.cols};
        level.highest = coding.domains[c].highest;
        level.values = MarginGrid<std::int32_t>(inside.rows, inside.cols);
        level.quotients = MarginGrid<std::int16_t>(inside.rows, inside.cols);
        level.valid = MarginGrid<std::uint8_t>(inside.rows, inside.cols);
        fetch(c, {row0, col0, row1 - row0, col1 - col0},
              {level.values.row(row0 - inside.row0) + (col0 - inside.col0), row1 - row0,
               col1 - col0, level.values.stride()});
        state.levels.push_back(std::move(level));
        state.codecs.push_back(learnt[c]->descendant());
    }
    return state;
}

}  // namespace relief::codec
