#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/embedded_coder.h"
#include "codec/raster_header.h"
#include "codec/stream_layout.h"
#include "relief/core/stream.h"

/// From a pyramid to embedded streams and chunks. docs/format.md, "Streams of a pyramid".
namespace relief::codec {

/// [band][component]
template <class T>
using BandGrids = std::vector<std::vector<Grid<T>>>;

/// The bands of a layout, or parts of them.
struct QuantisedPyramid {
    std::vector<LatticeBox> boxes;  ///< of each band: what is here; empty ones are not
    BandGrids<std::int32_t> values;
    BandGrids<std::uint8_t> worths;  ///< see quantise_band; empty: no value is to be dropped
};

/// Requires: steps and means of `coding`.
[[nodiscard]] QuantisedPyramid quantise(const multires::Pyramid<double>& pyramid,
                                        const PyramidCoding& coding);

/// Of plane - mean.
[[nodiscard]] double largest_magnitude(const Grid<double>& plane, double mean);

/// The least step for which all values have 30 bits.
[[nodiscard]] double least_step(const multires::Pyramid<double>& pyramid,
                                const std::vector<double>& means);

void add_to(GridView<double> plane, double mean);

/// Steps of at most 2^-24 of the largest magnitude of each band.
[[nodiscard]] PyramidCoding fine_coding(const multires::Pyramid<double>& pyramid,
                                        const std::vector<double>& means);

/// What is known of the pyramid when the first of several streams and of the others, or of the only
/// one, all planes down to `layer_plane` are, and no details of `finest_level` and finer ones.
/// `out` is allocated.
void reconstruct(const QuantisedPyramid& quantised, const PyramidCoding& coding, int layer_plane,
                 int finest_level, multires::Pyramid<double>& out);

/// How many coefficients are not zero in some component, scaling band included.
[[nodiscard]] std::int64_t count_kept(const QuantisedPyramid& quantised);

/// One embedded stream for each component.
using CodedStream = std::vector<EmbeddedStream>;

/// One stream, whose bands are in `quantised`; those of its parent are in `above`, which may be the
/// same. Drops values that are not worth their bits. Errors: as encode_streams.
[[nodiscard]] Result<CodedStream> encode_one_stream(const multires::PyramidLayout& layout,
                                                    const StreamLayout& streams, std::size_t number,
                                                    QuantisedPyramid& quantised,
                                                    const QuantisedPyramid& above);

/// The streams of some groups of a layout, coarse ones first; all others are empty. Drops values
/// that are not worth their bits. The same for any number of threads. Errors: InvalidArgument when
/// a value has more than 30 bits.
[[nodiscard]] Result<std::vector<CodedStream>> encode_streams(
    const multires::PyramidLayout& layout, const StreamLayout& streams, QuantisedPyramid& quantised,
    std::span<const StreamLayout::Group> groups);

/// All of them.
[[nodiscard]] Result<std::vector<CodedStream>> encode_streams(const multires::PyramidLayout& layout,
                                                              const StreamLayout& streams,
                                                              QuantisedPyramid& quantised);

/// The lowest planes of layers that are worth a directory entry for each stream.
[[nodiscard]] std::vector<int> choose_layers(const std::vector<CodedStream>& streams);

/// The chunk of a stream in layer k.
[[nodiscard]] Bytes chunk_of(const CodedStream& stream, const std::vector<int>& layers,
                             std::size_t k);

/// The chunks, in the order of ChunkOrder.
[[nodiscard]] std::vector<Bytes> chunks_of(const std::vector<CodedStream>& streams,
                                           const std::vector<int>& layers);

/// The bytes of a component's stream, as far as they are known.
struct StreamText {
    int planes = 0;
    Bytes bytes;
};

/// Adds what a chunk says to the components' streams. Errors: BadFile.
Status append_chunk(std::span<const std::uint8_t> chunk, std::vector<StreamText>& components);

}  // namespace relief::codec
