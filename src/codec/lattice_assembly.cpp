#include "codec/lattice_assembly.h"

#include <algorithm>
#include <utility>

namespace relief::codec {

TileSummary summary_of(const EncodedTile& tile) {
    return {tile.error, tile.coarse_errors, tile.nonzero, tile.repairs};
}

LatticeAssembly::LatticeAssembly(const TileTree& tree, bool measured)
    : tree_(tree), measured_(measured) {
    for (int k = 0; k < tree.tiers(); ++k)
        tiles_.emplace_back(static_cast<std::size_t>(tree.tier(k).tiles()));
}

void LatticeAssembly::add_coarse(int tier, std::int64_t tile, std::vector<SpooledChunk> chunks) {
    if (tier == 1 && measured_) chunks.back().info.bound = 0;  // grows with the tiles
    at(tier, tile) = std::move(chunks);
}

void LatticeAssembly::add_finest(std::int64_t tile, std::vector<SpooledChunk> chunks,
                                 const TileSummary& about) {
    const std::size_t n = chunks.size();
    chunks[n - 1].info.bound = about.error.max;
    for (std::size_t k = 0; k + 1 < n && k < about.coarse_errors.size(); ++k)
        chunks[n - 2 - k].info.bound = about.coarse_errors[k];
    if (tree_.tiers() > 1 && !about.coarse_errors.empty()) {
        // Without any chunk of this tile: what the tier above promises here.
        double& promised = at(1, tree_.parent(0, tile)).back().info.bound;
        promised = std::max(promised, about.coarse_errors.back());
    }
    result_.max_error = std::max(result_.max_error, about.error.max);
    result_.square_error += about.error.square;
    result_.nonzero += about.nonzero;
    result_.repairs += about.repairs;
    at(0, tile) = std::move(chunks);
}

LatticeEncoding LatticeAssembly::finish() && {
    // Coarse tiers first; within a tier level by level, tiles along a Hilbert curve.
    for (int k = tree_.tiers() - 1; k >= 0; --k) {
        const std::vector<std::int64_t> order = tree_.hilbert_order(k);
        for (std::size_t range = 0; range < chunk_ranges(tree_, k).size(); ++range)
            for (const std::int64_t tile : order) result_.chunks.push_back(at(k, tile)[range]);
    }
    return std::move(result_);
}

}  // namespace relief::codec
