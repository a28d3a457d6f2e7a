#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/tile_tree.h"
#include "relief/multires/pyramid.h"

/// How the bands of a pyramid are cut into embedded streams. docs/format.md, "Streams of a
/// pyramid".
namespace relief::codec {

/// The part of a band that a stream holds.
struct BandPart {
    std::size_t band = 0;  ///< of the layout
    LatticeBox box;        ///< in the band's lattice; perhaps empty
};

/// Where the chunk of a stream in a layer stands among the chunks of all: first the layers of the
/// first stream, then layer by layer those of the others.
struct ChunkOrder {
    std::size_t layers = 1;
    std::size_t streams = 1;

    [[nodiscard]] std::size_t count() const { return layers * streams; }
    [[nodiscard]] std::size_t place(std::size_t layer, std::size_t stream) const {
        return stream == 0 ? layer : layers + layer * (streams - 1) + stream - 1;
    }
    /// The last one that belongs to a layer of all streams.
    [[nodiscard]] std::size_t end_of(std::size_t layer) const { return place(layer, streams - 1); }
};

/// Streams: one for each tile and level, tiles of tier k holding the details of levels 3k + 1 ..
/// 3k + 3. Coarse levels of the one tile of the top tier share a stream; the scaling band is with
/// the details of its level. Streams are numbered coarse levels first, within a level along a
/// Hilbert curve.
class StreamLayout {
  public:
    /// Streams of all levels from `coarsest` to `finest` of the tiles of one tier, one each.
    struct Group {
        int tier = 0;
        int coarsest = 0;
        int finest = 0;
        std::size_t first = 0;  ///< number of its first stream
        std::size_t count = 1;
    };

    explicit StreamLayout(const multires::PyramidLayout& layout);

    /// How many streams a layout has. Complexity: O(levels), whatever the size.
    [[nodiscard]] static std::uint64_t count(const multires::PyramidLayout& layout);

    [[nodiscard]] std::size_t streams() const {
        return groups_.back().first + groups_.back().count;
    }
    /// Coarse ones first.
    [[nodiscard]] const std::vector<Group>& groups() const { return groups_; }
    /// The group of a stream.
    [[nodiscard]] std::size_t group_of(std::size_t stream) const;
    /// The group that holds the details of `level`.
    [[nodiscard]] std::size_t group_of_level(int level) const;

    /// The stream of a group for a tile of its tier, numbered as in TileTree.
    [[nodiscard]] std::size_t stream_of(std::size_t group, std::int64_t tile) const {
        return stream(groups_[group], tile);
    }
    /// The stream with the coefficients that lie over those of `stream`; none for the first ones.
    [[nodiscard]] std::optional<std::size_t> parent(std::size_t stream) const;
    /// The bands of a stream, in the order of the layout, which is the order of coding.
    [[nodiscard]] std::vector<BandPart> parts(std::size_t stream) const;
    /// The streams of a group that hold coefficients of `level` inside `box` of its lattice, in
    /// ascending order. Requires: a level of the group; a box that is not empty.
    [[nodiscard]] std::vector<std::size_t> meeting(std::size_t group, int level,
                                                   const LatticeBox& box) const;
    /// The samples of the raster that lie in the tile of a stream.
    [[nodiscard]] LatticeBox samples(std::size_t stream) const;

  private:
    struct Order {
        std::vector<std::int64_t> tiles;  ///< along the curve
        std::vector<std::size_t> places;  ///< of each tile on it
    };

    [[nodiscard]] std::int64_t tile(const Group& group, std::size_t stream) const;
    [[nodiscard]] std::size_t stream(const Group& group, std::int64_t tile) const;
    [[nodiscard]] LatticeBox range(int tier, std::int64_t tile, int level) const;

    const multires::PyramidLayout& layout_;
    TileTree tree_;
    std::vector<Group> groups_;
    std::vector<Order> orders_;  ///< by tier
};

}  // namespace relief::codec
