#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "relief/core/grid.h"
#include "relief/core/result.h"

/// Entropy coding of the quantised bands of one level. docs/format.md, "Level chunks".
namespace relief::codec {

/// A band of quantised coefficients: values(r, c) belongs to lattice point (box.row0 + r, box.col0
/// + c).
struct BandView {
    LatticeBox box;
    GridView<std::int32_t> values;  ///< box.rows x box.cols; any int32
    bool predict = false;  ///< large smooth values (a scaling band): code differences from a
                           ///< median-edge prediction
};

/// Codes bands in order, each with the help of those before it and of the level above.
/// Requires: values of the size of box, coordinates within +-2^31. `parents` is empty, or as long
/// as `bands`: parents[k] is the band of the next coarser level with the channel of bands[k] (an
/// empty box: none), whose point (i >> 1, j >> 1) lies over (i, j). Complexity: O(coefficients x
/// bands); empty regions cost a small part of it.
[[nodiscard]] std::vector<std::uint8_t> encode_level(std::span<const BandView> bands,
                                                     std::span<const BandView> parents);

/// The bits that encode_level would need, by its probabilities alone: for rate control and tests.
/// The bytes differ from it by less than 0.5 % and 5 bytes.
[[nodiscard]] double level_bits(std::span<const BandView> bands, std::span<const BandView> parents);

/// Fills the values of `bands`, whose boxes and flags, and the parents, must be those that were
/// encoded. Never reads past `bytes`; time and memory depend on the boxes alone. Errors:
/// InvalidArgument when a view has not the size of its box; BadFile when the bytes end too early or
/// too late (values are unspecified then). Other damage is not noticed here: the container's
/// checksums are for that.
Status decode_level(std::span<const std::uint8_t> bytes, std::span<BandView> bands,
                    std::span<const BandView> parents);

}  // namespace relief::codec
