#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "codec/embedded_coder.h"
#include "codec/raster_header.h"
#include "codec/stream_layout.h"
#include "relief/codec/container.h"

namespace relief::codec {

/// Coefficients that were read.
struct PyramidPart {
    std::vector<multires::Planes<double>> bands;  ///< [band][component], of the boxes asked for
    /// How many layers are known of what was read: everywhere at least `fewest`. Of several streams
    /// the first does not count for the most: it stands before all layers of the others.
    std::size_t fewest_layers = 0;
    std::size_t most_layers = 0;
    std::vector<LatticeBox> damaged = {};  ///< parts of the raster whose chunks are bad
};

/// The surface of scheme `cubic` on a window of the lattice of `level`. Requires: `part` has the
/// boxes that cubic::needed_boxes names. Errors: those of cubic::synthesise_window.
[[nodiscard]] Result<multires::Planes<double>> cubic_surface(const multires::PyramidLayout& layout,
                                                             int level, const LatticeBox& window,
                                                             const PyramidPart& part);

/// Decodes the streams of an open-loop file on demand and keeps those used last. Several threads
/// may read at once.
class PyramidBlocks {
  public:
    /// All must outlive this. `first_chunk`: the number of the first one in the container, which
    /// has all the others.
    PyramidBlocks(const ContainerReader& container, const multires::PyramidLayout& layout,
                  const PyramidCoding& coding, std::size_t first_chunk);

    [[nodiscard]] const StreamLayout& streams() const { return streams_; }
    [[nodiscard]] std::size_t chunk(std::size_t layer, std::size_t stream) const {
        return first_chunk_ + order_.place(layer, stream);
    }
    /// The last chunk of a layer.
    [[nodiscard]] std::size_t end_of(std::size_t layer) const {
        return first_chunk_ + order_.end_of(layer);
    }
    /// Behind all of them.
    [[nodiscard]] std::size_t end() const { return first_chunk_ + order_.count(); }

    /// boxes[k] is what is wanted of band k, inside it; empty ones are not read. What chunks do not
    /// tell is taken to be as probable as zero. Details of `finest_level` and finer ones are not
    /// read but 0. Errors: BadFile when the first chunk is not there.
    /// Complexity: O(coefficients of the streams that meet the boxes).
    [[nodiscard]] Result<PyramidPart> read(const std::vector<LatticeBox>& boxes,
                                           int finest_level = 0) const;

  private:
    struct Block {
        std::vector<BandPart> parts;
        std::vector<Grid<std::int32_t>> values;  ///< component x parts + part
        std::vector<KnownBits> known;            ///< of each component
        std::size_t layers = 0;
        bool damaged = false;
    };
    using BlockPointer = std::shared_ptr<const Block>;

    [[nodiscard]] Result<BlockPointer> block(std::size_t stream) const;
    [[nodiscard]] Result<Block> decode(std::size_t stream) const;
    Status decode_component(std::size_t component, std::span<const std::uint8_t> bytes, int planes,
                            const Block* above, Block& block) const;
    void copy(const Block& block, const std::vector<LatticeBox>& boxes, PyramidPart& out) const;

    const ContainerReader& container_;
    const multires::PyramidLayout& layout_;
    const PyramidCoding& coding_;
    std::size_t first_chunk_;
    StreamLayout streams_;
    ChunkOrder order_;
    std::size_t capacity_;
    mutable std::mutex mutex_;
    mutable std::list<std::pair<std::size_t, BlockPointer>> recent_;  ///< the latest used first
    mutable std::map<std::size_t, std::list<std::pair<std::size_t, BlockPointer>>::iterator> index_;
};

}  // namespace relief::codec
