#pragma once

#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "codec/tile_codec.h"
#include "relief/codec/container.h"

/// Samples of a closed-loop file, by windows and levels.
namespace relief::codec {

/// Which chunk is what: chunks of coarse tiers first, level by level, tiles along a Hilbert curve.
class LatticeChunks {
  public:
    /// `first`: the number of the first of them in the file.
    LatticeChunks(const TileTree& tree, std::size_t first);

    /// The chunk of a tile's k-th range.
    [[nodiscard]] std::size_t chunk(int tier, std::size_t range, std::int64_t tile) const;
    [[nodiscard]] const std::vector<LevelRange>& ranges(int tier) const {
        return tiers_[static_cast<std::size_t>(tier)].ranges;
    }
    /// All chunks from the first to the last of `level`, which come before all finer ones.
    [[nodiscard]] std::size_t end_of_level(int level) const;
    [[nodiscard]] std::size_t end() const { return end_of_level(0); }

  private:
    struct Tier {
        std::size_t first = 0;
        std::vector<LevelRange> ranges;
        std::vector<std::int64_t> place;  ///< of each tile along the curve
    };
    const TileTree& tree_;
    std::vector<Tier> tiers_;
};

/// What a window of a level turned out to be.
struct LatticeWindow {
    std::vector<Grid<double>> planes;  ///< as stored; holes are NaN
    Grid<std::uint8_t> mask;           ///< empty: all valid
    /// The coarsest level at which some tile of the window ended for lack of data: the level asked
    /// for, if all was there.
    int known_level = 0;
    /// Largest bound of the tiles' last chunks that were used; infinite: not known.
    double bound = 0;
    std::vector<LatticeBox> damaged;  ///< parts, in samples of the raster, whose chunks are bad
};

/// Decodes tiles on demand and keeps coarse ones. Several threads may read at once.
class LatticeFile {
  public:
    /// The container must outlive this. Errors: BadFile when it has not the chunks of the tree.
    [[nodiscard]] static Result<std::unique_ptr<LatticeFile>> open(const ContainerReader& container,
                                                                   std::size_t first_chunk,
                                                                   LatticeCoding coding,
                                                                   std::int64_t rows,
                                                                   std::int64_t cols);

    [[nodiscard]] const TileTree& tree() const { return tree_; }
    [[nodiscard]] const LatticeChunks& chunks() const { return chunks_; }
    [[nodiscard]] const LatticeCoding& coding() const { return coding_; }

    /// Samples of `window`, in the lattice of `level`. Requires: 0 <= level <= tree().levels(), a
    /// window inside the lattice. What is not there is interpolated from coarser levels; damaged
    /// chunks too, and they are named. Errors: BadFile when not even the first chunk is there.
    /// fill_holes: holes have interpolated values instead of NaN.
    [[nodiscard]] Result<LatticeWindow> read(int level, const LatticeBox& window,
                                             bool fill_holes = false) const;

    /// The state before the first level of a finest tile, to encode it over the tiers above.
    /// Errors: BadFile when they are not all there.
    [[nodiscard]] Result<TileState> start_of_finest(std::int64_t number) const;

  private:
    struct Tile {
        TileState state;
        Grid<std::uint8_t> valid;
        int known_level = 0;
        double bound = 0;
        bool damaged = false;
    };
    using TilePointer = std::shared_ptr<const Tile>;
    struct Key {
        int tier;
        std::int64_t tile;
        auto operator<=>(const Key&) const = default;
    };

    LatticeFile(const ContainerReader& container, std::size_t first_chunk, LatticeCoding coding,
                std::int64_t rows, std::int64_t cols);

    /// A tile decoded to `level` or the next finer level that ends a chunk.
    [[nodiscard]] Result<Tile> decode(int tier, std::int64_t number, int level) const;
    /// A tile of a coarse tier, to its finest level, from the cache.
    [[nodiscard]] Result<TilePointer> coarse(int tier, std::int64_t number) const;
    [[nodiscard]] Result<TileState> start(int tier, std::int64_t number, Tile& about) const;
    static void inherit_repairs(const Tile& above, const LatticeBox& over, int tier,
                                const LatticeBox& box, TileState& state);
    [[nodiscard]] Grid<std::uint8_t> mask_from_above(int tier, std::int64_t number) const;
    void copy_tile(const Tile& tile, int tier, std::int64_t number, int level,
                   const LatticeBox& window, bool fill_holes, LatticeWindow& out) const;

    /// Calls visit(r, c) for the holes of a tile of `tier` in a window of the level's lattice.
    template <class Visit>
    void visit_holes(const Grid<std::uint8_t>& valid, int tier, std::int64_t number, int level,
                     const LatticeBox& window, Visit visit) const;

    const ContainerReader& container_;
    TileTree tree_;
    LatticeChunks chunks_;
    LatticeCoding coding_;
    std::size_t capacity_;  ///< coarse tiles that are kept
    mutable std::mutex mutex_;
    mutable std::list<std::pair<Key, TilePointer>> recent_;  ///< the latest used first
    mutable std::map<Key, std::list<std::pair<Key, TilePointer>>::iterator> index_;
};

}  // namespace relief::codec
