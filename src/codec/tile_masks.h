#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "codec/tile_tree.h"
#include "relief/codec/container.h"

/// Which samples of an open-loop file are valid: a chunk for each tile of the finest tier, along
/// the Hilbert curve. docs/format.md, "Streams of a pyramid".
namespace relief::codec {

/// The chunk of a tile: empty if all samples are valid.
[[nodiscard]] Bytes encode_tile_mask(GridView<const std::uint8_t> mask);

/// Decodes masks on demand and keeps those used last. Several threads may read at once.
class TileMasks {
  public:
    /// `container` must outlive this and have a chunk for each tile from `first_chunk` on.
    TileMasks(const ContainerReader& container, std::int64_t rows, std::int64_t cols,
              std::size_t first_chunk);

    [[nodiscard]] static std::uint64_t chunks(std::int64_t rows, std::int64_t cols) {
        return static_cast<std::uint64_t>(TileTree(rows, cols).tier(0).tiles());
    }

    /// The samples of a window of `level`, 0 for those in tiles whose chunk is bad or not at hand;
    /// these tiles are added to `damaged`. Complexity: O(tiles that the window meets).
    [[nodiscard]] Grid<std::uint8_t> read(int level, const LatticeBox& window,
                                          std::vector<LatticeBox>& damaged) const;

  private:
    using MaskPointer = std::shared_ptr<const Grid<std::uint8_t>>;  ///< of a tile; null: damaged

    [[nodiscard]] MaskPointer tile(std::int64_t number) const;
    [[nodiscard]] MaskPointer decode(std::int64_t number) const;

    const ContainerReader& container_;
    TileTree tree_;
    std::size_t first_chunk_;
    std::vector<std::size_t> places_;  ///< of each tile on the curve
    std::size_t capacity_;
    mutable std::mutex mutex_;
    mutable std::map<std::int64_t, MaskPointer> kept_;
};

}  // namespace relief::codec
