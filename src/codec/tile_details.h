#pragma once

#include <cstdint>
#include <vector>

#include "codec/pyramid_code.h"
#include "codec/tile_tree.h"
#include "relief/codec/oracle.h"
#include "relief/codec/raster_codec.h"

/// The finest levels of scheme `cubic` tile by tile, each over a window of the raster that is wider
/// than the tile. docs/codec.md, "Rasters larger than memory".
namespace relief::codec {

/// Levels that are chosen block by block.
inline constexpr int kFine = TileTree::kTierLevels;
/// One unit of their coarsest lattice holds so many samples a side.
inline constexpr std::int64_t kUnit = std::int64_t{1} << kFine;

struct Block {
    std::int64_t tile = 0;
    LatticeBox core;    ///< the samples of its tile
    LatticeBox window;  ///< those that it looks at
};

[[nodiscard]] std::vector<Block> blocks_of(const TileTree& tree);

/// The part of `all` of the lattice of `level` that a block's core holds; one at an end of the
/// raster holds all that is beyond it, too.
[[nodiscard]] LatticeBox lattice_of(const Block& block, int level, const LatticeBox& raster,
                                    const LatticeBox& all);

/// A window of the raster and the same with its holes filled: with 0 where there is nothing to fill
/// them from.
struct Window {
    Raster samples;
    multires::Planes<double> filled;

    [[nodiscard]] Target target() const;
};

/// Errors: those of the source.
[[nodiscard]] Result<Window> read_window(const RasterSource& source, const LatticeBox& box);

/// The pyramid of a window that has only the levels up to kFine, of a raster's `layout`.
[[nodiscard]] Result<multires::PyramidLayout> fine_layout(const multires::PyramidLayout& layout,
                                                          const LatticeBox& window);

/// The number of bands of levels above kFine, the scaling band included.
[[nodiscard]] std::size_t coarse_bands(const multires::PyramidLayout& layout);

/// What blocks are coded over.
struct CoarserLevels {
    const multires::Planes<double>& surface;  ///< that they give, at level kFine
    const QuantisedPyramid& quantised;
    const PyramidCoding& coding;  ///< of all levels
    Effort effort;
};

/// Details of a block's core, quantised as bands of `layout`; there are none in coarser bands.
/// With Effort::Refit they are fitted to what the coarser levels leave, otherwise they are those of
/// the raster. Errors: those of the source. Complexity: O(samples of the window).
[[nodiscard]] Result<QuantisedPyramid> choose_details(const RasterSource& source,
                                                      const multires::PyramidLayout& layout,
                                                      const Block& block,
                                                      const CoarserLevels& coarser);

}  // namespace relief::codec
