#pragma once

#include <cstdint>
#include <vector>

#include "codec/spooled_file.h"
#include "codec/tile_codec.h"

/// From coded tiles to the file that they make: what is known of its errors, and the order of its
/// chunks. docs/format.md, "Tiles of lattices".
namespace relief::codec {

/// A closed-loop file before its header.
struct LatticeEncoding {
    LatticeCoding coding;
    std::vector<SpooledChunk> chunks;  ///< in the order of the file
    std::int64_t samples = 0;          ///< valid ones
    std::int64_t nonzero = 0;
    std::int64_t repairs = 0;
    bool has_holes = false;
    double max_error = 0;
    double square_error = 0;
    /// Sum of squares of the samples less the bilinear surface through the coarsest lattice.
    double coarse_energy = 0;
};

/// What is told of a finest tile beside its chunks.
struct TileSummary {
    TileError error;
    std::vector<double> coarse_errors;  ///< as of EncodedTile; none: not measured
    std::int64_t nonzero = 0;
    std::int64_t repairs = 0;
};
[[nodiscard]] TileSummary summary_of(const EncodedTile& tile);

class LatticeAssembly {
  public:
    /// measured: finest tiles bring coarse_errors.
    LatticeAssembly(const TileTree& tree, bool measured);

    void add_coarse(int tier, std::int64_t tile, std::vector<SpooledChunk> chunks);
    /// All coarse tiles come first, then finest ones in ascending order, so that sums are the same
    /// however they were made.
    void add_finest(std::int64_t tile, std::vector<SpooledChunk> chunks, const TileSummary& about);

    /// Chunks and sums; all tiles were added.
    [[nodiscard]] LatticeEncoding finish() &&;

  private:
    [[nodiscard]] std::vector<SpooledChunk>& at(int tier, std::int64_t tile) {
        return tiles_[static_cast<std::size_t>(tier)][static_cast<std::size_t>(tile)];
    }

    const TileTree& tree_;
    bool measured_;
    std::vector<std::vector<std::vector<SpooledChunk>>> tiles_;  ///< [tier][tile]: chunks
    LatticeEncoding result_;
};

}  // namespace relief::codec
