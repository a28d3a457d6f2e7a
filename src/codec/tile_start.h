#pragma once

#include <functional>

#include "codec/tile_codec.h"

namespace relief::codec {

/// Copies samples of a box of tier k's lattice, of one component, to `out`, whose element (0, 0) is
/// the box's first.
using FetchSamples =
    std::function<void(std::size_t component, const LatticeBox& box, GridView<std::int32_t> out)>;

/// The state of a tile before its first level, below the top tier: the coarse samples with those of
/// its neighbours around them. `learnt`: codecs of the parent tile after its finest level.
[[nodiscard]] TileState state_below(const LatticeCoding& coding, const TileTree& tree, int tier,
                                    std::int64_t tile,
                                    const std::vector<std::unique_ptr<LevelCodec>>& learnt,
                                    const FetchSamples& fetch);

}  // namespace relief::codec
