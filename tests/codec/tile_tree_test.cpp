#include "codec/tile_tree.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace relief::codec {
namespace {

TEST(TileTree, TilesCoverEverySampleOfATierOnce) {
    EXPECT_TRUE(rc::check([] {
        const auto rows = *rc::gen::inRange<std::int64_t>(1, 5000);
        const auto cols = *rc::gen::inRange<std::int64_t>(1, 5000);
        const TileTree tree(rows, cols);
        for (int k = 0; k < tree.tiers(); ++k) {
            const auto& tier = tree.tier(k);
            RC_ASSERT(tier.rows == level_size(rows, 3 * k));
            std::int64_t sum = 0;
            for (std::int64_t tile = 0; tile < tier.tiles(); ++tile) {
                const LatticeBox box = tree.box(k, tile);
                sum += box.count();
                RC_ASSERT(box.row0 % TileTree::kTile == 0);
                RC_ASSERT(box.rows < 768 && box.cols < 768);
                RC_ASSERT(tier.tile_rows == 1 || box.rows >= 256);
                RC_ASSERT(tree.tiles_meeting(k, box) ==
                          (LatticeBox{tile / tier.tile_cols, tile % tier.tile_cols, 1, 1}));
                if (k + 1 == tree.tiers()) continue;
                const LatticeBox above = tree.box(k + 1, tree.parent(k, tile));
                RC_ASSERT(above.contains(box.row0 >> 3, box.col0 >> 3));
            }
            RC_ASSERT(sum == tier.rows * tier.cols);
        }
        RC_ASSERT(tree.tier(tree.tiers() - 1).tiles() == 1);
        RC_ASSERT(level_size(std::max(rows, cols), tree.levels()) <= 2);
    }));
}

TEST(TileTree, NeighboursOnTheCurveAreNeighbours) {
    const TileTree tree(512 * 8, 512 * 8);
    const std::vector<std::int64_t> order = tree.hilbert_order(0);
    ASSERT_EQ(order.size(), 64U);
    std::vector<std::int64_t> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (std::int64_t k = 0; k < 64; ++k) EXPECT_EQ(sorted[static_cast<std::size_t>(k)], k);
    for (std::size_t k = 1; k < order.size(); ++k)
        EXPECT_EQ(
            std::abs(order[k] / 8 - order[k - 1] / 8) + std::abs(order[k] % 8 - order[k - 1] % 8),
            1)
            << k;
}

TEST(TileTree, SmallRastersAreOneTile) {
    const TileTree one(1, 1);
    EXPECT_EQ(one.tiers(), 1);
    EXPECT_EQ(one.levels(), 0);
    EXPECT_EQ(TileTree(767, 3).tiers(), 1);
    EXPECT_EQ(TileTree(768, 3).tiers(), 2);
    EXPECT_EQ(TileTree(344, 403).levels(), 8);
}

}  // namespace
}  // namespace relief::codec
