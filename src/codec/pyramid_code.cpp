#include "codec/pyramid_code.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/bytes.h"
#include "codec/embedded_quantiser.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

constexpr double kLargestValue = 0x1p29;
/// Bands that are smaller count as if they were of this size.
constexpr double kSmallestMagnitude = 0x1p-200;
/// A layer lets the file grow by this factor at least.
constexpr double kLayerGrowth = 1.25;
/// All layers but the last may take this part of the file for their entries in the directory: of
/// so many bytes for a chunk, or for one that is empty.
constexpr double kLayerShare = 0.01;
/// The first layer holds so many times what its entries take.
constexpr double kLeastContent = 8;
constexpr double kEntry = 8;
constexpr double kEmptyEntry = 3;

/// plane - mean.
Grid<double> centred(const Grid<double>& plane, double mean) {
    Grid<double> result(plane.rows(), plane.cols());
    for (std::int64_t r = 0; r < plane.rows(); ++r)
        for (std::int64_t c = 0; c < plane.cols(); ++c) result(r, c) = plane(r, c) - mean;
    return result;
}

/// Without the bits below `plane`.
Grid<std::int32_t> cut_off(const Grid<std::int32_t>& values, int plane) {
    Grid<std::int32_t> known(values.rows(), values.cols());
    for (std::int64_t r = 0; r < values.rows(); ++r)
        for (std::int64_t c = 0; c < values.cols(); ++c)
            known(r, c) = values(r, c) / (1 << plane) * (1 << plane);
    return known;
}

constexpr int kMostPlanes = 31;

/// Bytes of a stream that hold all planes down to `plane`.
std::size_t bytes_down_to(const EmbeddedStream& stream, int plane) {
    if (stream.planes <= plane) return 0;
    return stream.ends[3 * static_cast<std::size_t>(stream.planes - plane) - 1].bytes;
}

std::size_t size_down_to(std::span<const CodedStream> streams, int plane) {
    std::size_t size = 0;
    for (const CodedStream& components : streams)
        for (const EmbeddedStream& stream : components) size += bytes_down_to(stream, plane);
    return size;
}

}  // namespace

Result<CodedStream> encode_one_stream(const multires::PyramidLayout& layout,
                                      const StreamLayout& streams, std::size_t number,
                                      QuantisedPyramid& quantised, const QuantisedPyramid& above) {
    const std::vector<BandPart> parts = streams.parts(number);
    const std::optional<std::size_t> parent = streams.parent(number);
    const std::vector<BandPart> parent_parts =
        parent ? streams.parts(*parent) : std::vector<BandPart>();
    CodedStream coded;
    for (std::size_t c = 0; c < static_cast<std::size_t>(layout.components); ++c) {
        std::vector<StreamBand> bands;
        for (const BandPart& part : parts) {
            const multires::BandLayout& band = layout.bands[part.band];
            const LatticeBox& here = quantised.boxes[part.band];
            const LatticeBox box = relative(part.box, here.row0, here.col0);
            StreamBand& added =
                bands.emplace_back(StreamBand{band.level, band.channel, part.box,
                                              part_of(quantised.values[part.band][c].view(), box)});
            if (!quantised.worths.empty())
                added.worth = part_of(std::as_const(quantised.worths[part.band][c]).view(), box);
        }
        std::vector<ParentBand> parents;
        for (const BandPart& part : parent_parts) {
            const multires::BandLayout& band = layout.bands[part.band];
            const LatticeBox& there = above.boxes[part.band];
            parents.push_back({band.level, band.channel, part.box,
                               part_of(above.values[part.band][c].view(),
                                       relative(part.box, there.row0, there.col0))});
        }
        RELIEF_TRY(EmbeddedStream stream, encode_stream(bands, parents));
        coded.push_back(std::move(stream));
    }
    return coded;
}

void add_to(GridView<double> plane, double mean) {
    for (std::int64_t r = 0; r < plane.rows; ++r)
        for (std::int64_t c = 0; c < plane.cols; ++c) plane(r, c) += mean;
}

QuantisedPyramid quantise(const multires::Pyramid<double>& pyramid, const PyramidCoding& coding) {
    QuantisedPyramid result;
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
        const double step = coding.step_of(pyramid.layout, k);
        result.boxes.push_back(pyramid.layout.bands[k].box);
        std::vector<Grid<std::int32_t>> values;
        std::vector<Grid<std::uint8_t>> worths;
        for (std::size_t c = 0; c < pyramid.bands[k].size(); ++c) {
            const Grid<double>& plane = pyramid.bands[k][c];
            const Grid<double> shifted = k == 0 ? centred(plane, coding.means[c]) : Grid<double>();
            values.emplace_back(plane.rows(), plane.cols());
            worths.emplace_back(plane.rows(), plane.cols());
            quantise_band<double>(k == 0 ? shifted.view() : plane.view(), step,
                                  values.back().view(), worths.back().view());
        }
        result.values.push_back(std::move(values));
        result.worths.push_back(std::move(worths));
    }
    return result;
}

double largest_magnitude(const Grid<double>& plane, double mean) {
    double largest = 0;
    for (std::int64_t r = 0; r < plane.rows(); ++r)
        for (std::int64_t c = 0; c < plane.cols(); ++c)
            largest = std::max(largest, std::abs(plane(r, c) - mean));
    return largest;
}

double least_step(const multires::Pyramid<double>& pyramid, const std::vector<double>& means) {
    double least = 0;
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
        for (std::size_t c = 0; c < pyramid.bands[k].size(); ++c) {
            const Grid<double>& plane = pyramid.bands[k][c];
            const double largest = largest_magnitude(plane, k == 0 ? means[c] : 0);
            least = std::max(least, largest * pyramid.layout.bands[k].norm_samples / kLargestValue);
        }
    return least;
}

PyramidCoding fine_coding(const multires::Pyramid<double>& pyramid,
                          const std::vector<double>& means) {
    constexpr int bits = 25;
    PyramidCoding coding;
    coding.means = means;
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
        double largest = kSmallestMagnitude;
        for (std::size_t c = 0; c < pyramid.bands[k].size(); ++c)
            largest =
                std::max(largest, largest_magnitude(pyramid.bands[k][c], k == 0 ? means[c] : 0));
        coding.exponents.push_back(std::ilogb(largest) + 1 - bits);
    }
    return coding;
}

void reconstruct(const QuantisedPyramid& quantised, const PyramidCoding& coding, int layer_plane,
                 int finest_level, multires::Pyramid<double>& out) {
    const std::vector<StreamLayout::Group> groups = StreamLayout(out.layout).groups();
    // The only stream has layers like others; the first of several is whole before their first.
    const auto is_whole = [&](const multires::BandLayout& band) {
        return groups.size() > 1 && band.level >= groups[0].finest;
    };
    for (std::size_t k = 0; k < out.bands.size(); ++k)
        for (std::size_t c = 0; c < out.bands[k].size(); ++c) {
            GridView<double> band = out.bands[k][c].view();
            const bool dropped = k > 0 && out.layout.bands[k].level <= finest_level;
            if (dropped) {
                for (std::int64_t r = 0; r < band.rows; ++r)
                    std::fill_n(band.row(r), band.cols, 0.0);
                continue;
            }
            const Grid<std::int32_t>& values = quantised.values[k][c];
            const int plane = is_whole(out.layout.bands[k]) ? 0 : layer_plane;
            const Grid<std::int32_t> known = plane > 0 ? cut_off(values, plane) : Grid<int>();
            reconstruct_band<double>(plane > 0 ? known.view() : values.view(), {plane, 3},
                                     coding.step_of(out.layout, k), band);
            if (k == 0) add_to(band, coding.means[c]);
        }
}

std::int64_t count_kept(const QuantisedPyramid& quantised) {
    std::int64_t kept = quantised.values[0][0].count();
    for (std::size_t k = 1; k < quantised.values.size(); ++k) {
        const auto& planes = quantised.values[k];
        for (std::int64_t r = 0; r < planes[0].rows(); ++r)
            for (std::int64_t c = 0; c < planes[0].cols(); ++c)
                kept += std::any_of(planes.begin(), planes.end(),
                                    [&](const auto& plane) { return plane(r, c) != 0; });
    }
    return kept;
}

Result<std::vector<CodedStream>> encode_streams(const multires::PyramidLayout& layout,
                                                const StreamLayout& streams,
                                                QuantisedPyramid& quantised) {
    return encode_streams(layout, streams, quantised, streams.groups());
}

Result<std::vector<CodedStream>> encode_streams(const multires::PyramidLayout& layout,
                                                const StreamLayout& streams,
                                                QuantisedPyramid& quantised,
                                                std::span<const StreamLayout::Group> groups) {
    std::vector<CodedStream> coded(streams.streams());
    // Contexts of a level look at what is left of the coarser one.
    for (const StreamLayout::Group& group : groups) {
        std::vector<Status> states(group.count);
        const auto count = static_cast<std::int64_t>(group.count);
        parallel_for(0, count, 1, [&](std::int64_t first, std::int64_t last) {
            for (auto k = static_cast<std::size_t>(first); k < static_cast<std::size_t>(last);
                 ++k) {
                Result<CodedStream> stream =
                    encode_one_stream(layout, streams, group.first + k, quantised, quantised);
                if (stream.ok())
                    coded[group.first + k] = *std::move(stream);
                else
                    states[k] = stream.error();
            }
        });
        for (const Status& state : states) RELIEF_CHECK(state);
    }
    return coded;
}

std::vector<int> choose_layers(const std::vector<CodedStream>& all) {
    const std::span<const CodedStream> streams = std::span(all).subspan(all.size() > 1 ? 1 : 0);
    std::vector<int> layers{0};
    const auto begun = [](int plane) {
        return [plane](const EmbeddedStream& stream) { return stream.planes > plane; };
    };
    double share = kLayerShare * static_cast<double>(size_down_to(all, 0));
    double below = static_cast<double>(size_down_to(streams, 0));
    for (int plane = 1; plane < kMostPlanes; ++plane) {
        const auto size = static_cast<double>(size_down_to(streams, plane));
        double cost = 0;
        for (const CodedStream& stream : streams)
            cost += std::any_of(stream.begin(), stream.end(), begun(plane)) ? kEntry : kEmptyEntry;
        if (size < kLeastContent * cost || below < kLayerGrowth * size || cost > share) continue;
        layers.insert(layers.begin(), plane);
        share -= cost;
        below = size;
    }
    return layers;
}

Bytes chunk_of(const CodedStream& components, const std::vector<int>& layers, std::size_t k) {
    ByteWriter out;
    bool says = false;
    for (const EmbeddedStream& stream : components) {
        const bool begun = k > 0 && stream.planes > layers[k - 1];
        const std::size_t from = begun ? bytes_down_to(stream, layers[k - 1]) : 0;
        const std::size_t to = bytes_down_to(stream, layers[k]);
        Bytes piece;
        if (!begun && stream.planes > layers[k])
            piece.push_back(static_cast<std::uint8_t>(stream.planes));
        piece.insert(piece.end(), stream.bytes.begin() + static_cast<std::ptrdiff_t>(from),
                     stream.bytes.begin() + static_cast<std::ptrdiff_t>(to));
        says = says || !piece.empty();
        if (components.size() > 1) out.varint(piece.size());
        out.bytes(piece);
    }
    return says ? out.take() : Bytes();
}

std::vector<Bytes> chunks_of(const std::vector<CodedStream>& streams,
                             const std::vector<int>& layers) {
    const ChunkOrder order{layers.size(), streams.size()};
    std::vector<Bytes> chunks(order.count());
    for (std::size_t k = 0; k < layers.size(); ++k)
        for (std::size_t number = 0; number < streams.size(); ++number)
            chunks[order.place(k, number)] = chunk_of(streams[number], layers, k);
    return chunks;
}

Status append_chunk(std::span<const std::uint8_t> chunk, std::vector<StreamText>& components) {
    if (chunk.empty()) return {};
    ByteReader in(chunk);
    for (StreamText& stream : components) {
        ByteReader piece(components.size() > 1 ? in.take(in.varint()) : in.rest());
        if (stream.planes == 0 && !piece.rest().empty()) stream.planes = piece.u8();
        const auto bytes = piece.rest();
        stream.bytes.insert(stream.bytes.end(), bytes.begin(), bytes.end());
    }
    if (!in.failed() && (components.size() == 1 || in.rest().empty())) return {};
    return Error{ErrorCode::BadFile, "its components do not fit; the file is damaged",
                 "stream chunk"};
}

}  // namespace relief::codec
