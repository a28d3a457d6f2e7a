#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "relief/core/grid.h"
#include "relief/core/result.h"

/// Embedded entropy coding of quantised bands, bit plane by bit plane, so that a stream can be cut
/// after any pass. docs/format.md, "Embedded streams".
///
/// A plane p is coded in three passes over all bands of the stream: 1 the coefficients that are
/// still zero and expected not to be, 2 the next bit of those that are not zero, 3 the rest.
namespace relief::codec {

/// A block of a band: values(r, c) belongs to lattice point (box.row0 + r, box.col0 + c).
struct StreamBand {
    int level = 1;    ///< 1: the finest
    int channel = 0;  ///< 0: scaling; details count from 1
    LatticeBox box;
    GridView<std::int32_t> values;         ///< box.rows x box.cols, above -2^31
    GridView<const std::uint8_t> worth{};  ///< for encoders: see quantise_band; empty: keep all
};

/// What is known of a coarser level: a block of one of its bands.
struct ParentBand {
    int level = 1;
    int channel = 0;
    LatticeBox box;
    GridView<const std::int32_t> values;
};

/// How much modelling: Dense mixes three sets of contexts, Fast uses one.
enum class StreamProfile : std::uint8_t { Dense, Fast };

/// The first `bytes` bytes of a stream hold everything up to this pass.
struct PassEnd {
    int plane = 0;
    int pass = 1;  ///< 1, 2, 3
    std::size_t bytes = 0;
};

struct EmbeddedStream {
    std::vector<std::uint8_t> bytes;
    int planes = 0;             ///< magnitudes are below 2^planes
    std::vector<PassEnd> ends;  ///< 3 for each plane, from plane planes - 1 down to 0
};

struct StreamOptions {
    StreamProfile profile = StreamProfile::Dense;
    /// Squared error, in steps, for which one bit is given up: a value of 1 that costs more becomes
    /// 0. Used where bands tell their worth.
    double squared_error_per_bit = 0.08;
};

/// Codes the bands of one block, coarse levels first. Values that were not worth their bits are
/// set to 0. The parent of a band is the band of its channel on the next coarser level, among
/// `bands` or else among `parents`; its point (i >> 1, j >> 1) lies over (i, j). Where there is
/// none, it counts as 0.
/// Complexity: O(coefficients x planes). Errors: InvalidArgument when a view has not the size of
/// its box, a magnitude exceeds 2^30, or boxes of a level lie more than 2^16 points apart.
[[nodiscard]] Result<EmbeddedStream> encode_stream(std::span<const StreamBand> bands,
                                                   std::span<const ParentBand> parents,
                                                   const StreamOptions& options = {});

/// The bits that encode_stream would need, by its probabilities alone. Values change as there.
[[nodiscard]] Result<double> stream_bits(std::span<const StreamBand> bands,
                                         std::span<const ParentBand> parents,
                                         const StreamOptions& options = {});

/// Which part of a stream there is.
struct StreamPart {
    std::span<const std::uint8_t> bytes;  ///< at least those of the end of the last pass
    int planes = 0;
    int passes = 0;  ///< how many of the 3 * planes passes to decode
};

/// How far values are known: all bits of planes above `plane`, and of `plane` what the passes up to
/// `pass` tell. Bits that are not known are 0.
struct KnownBits {
    int plane = 0;
    int pass = 3;
};

/// Fills the values of `bands`, whose levels, channels and boxes must be those that were encoded.
/// A plane of a band needs the same plane of its parent: parents must be known at least as far down
/// as the last plane decoded here (bits below it are not looked at). Never reads past the bytes;
/// time and memory depend on boxes and planes alone. Altered bytes give other values; checksums
/// are the container's business. Errors: InvalidArgument as in encode_stream; BadFile when the
/// number of planes or passes is out of range.
[[nodiscard]] Result<KnownBits> decode_stream(const StreamPart& part,
                                              std::span<const StreamBand> bands,
                                              std::span<const ParentBand> parents,
                                              StreamProfile profile = StreamProfile::Dense);

}  // namespace relief::codec
