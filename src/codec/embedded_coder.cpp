#include "codec/embedded_coder.h"

#include <algorithm>
#include <bit>
#include <string>

#include "codec/embedded_pass.h"

namespace relief::codec {

namespace {

constexpr int kMostPlanes = 31;
/// A unit of worth in squared steps.
constexpr double kWorthUnit = 1.0 / 64;
/// How many rows or columns the frame of a level may be larger than one of its bands.
constexpr std::int64_t kLargestSpread = 64;
constexpr std::int64_t kLargestCoordinate = std::int64_t{1} << 31;

Error wrong_argument(const StreamBand& band, std::string what) {
    return {ErrorCode::InvalidArgument, std::move(what),
            "band " + std::to_string(band.channel) + " of level " + std::to_string(band.level)};
}

bool in_range(const LatticeBox& box) {
    return box.rows >= 0 && box.cols >= 0 && box.rows <= kLargestCoordinate &&
           box.cols <= kLargestCoordinate && std::abs(box.row0) <= kLargestCoordinate &&
           std::abs(box.col0) <= kLargestCoordinate;
}

template <class T>
bool fits(const LatticeBox& box, const GridView<T>& values) {
    return values.rows == box.rows && values.cols == box.cols;
}

/// The least box with an even origin that holds all bands of a level.
LatticeBox frame_of(std::span<const StreamBand> bands, int level) {
    std::int64_t top = kLargestCoordinate;
    std::int64_t left = kLargestCoordinate;
    std::int64_t bottom = -kLargestCoordinate;
    std::int64_t right = -kLargestCoordinate;
    for (const StreamBand& band : bands) {
        if (band.level != level || band.box.count() == 0) continue;
        top = std::min(top, band.box.row0 & ~std::int64_t{1});
        left = std::min(left, band.box.col0 & ~std::int64_t{1});
        bottom = std::max(bottom, band.box.row0 + band.box.rows);
        right = std::max(right, band.box.col0 + band.box.cols);
    }
    return {top, left, bottom - top, right - left};
}

Status check(std::span<const StreamBand> bands, std::span<const ParentBand> parents) {
    for (const ParentBand& parent : parents)
        if (!in_range(parent.box) || !fits(parent.box, parent.values))
            return Error{ErrorCode::InvalidArgument,
                         "a parent's values have not the size of its box",
                         "level " + std::to_string(parent.level)};
    for (const StreamBand& band : bands) {
        if (!in_range(band.box) || !fits(band.box, band.values))
            return wrong_argument(band, "its values have not the size of its box");
        if (band.worth.count() != 0 && !fits(band.box, band.worth))
            return wrong_argument(band, "its worths have not the size of its box");
        if (band.channel < 0) return wrong_argument(band, "channels count from 0");
    }
    for (const StreamBand& band : bands) {
        if (band.box.count() == 0) continue;
        const LatticeBox frame = frame_of(bands, band.level);
        if (frame.rows > band.box.rows + kLargestSpread ||
            frame.cols > band.box.cols + kLargestSpread)
            return wrong_argument(band, "it must cover nearly the same points as its siblings");
    }
    return {};
}

/// Siblings that were coded before b are known to the same plane; the first detail band of a level
/// has to do with what is known of the second from the plane before.
void link_siblings(std::vector<EmbeddedBand>& bands, std::size_t b) {
    EmbeddedBand& band = bands[b];
    const auto is_sibling = [&](const EmbeddedBand& other) {
        return band.source.channel > 0 && other.source.channel > 0 &&
               other.source.level == band.source.level;
    };
    std::size_t earlier = 0;
    for (std::size_t k = b; k-- > 0 && earlier < 2;) {
        if (!is_sibling(bands[k])) continue;
        band.signed_siblings[earlier++] = &bands[k];
        band.siblings.push_back({&bands[k], 0, 0, 2});
        band.siblings.push_back({&bands[k], 0, 1, 1});
        band.siblings.push_back({&bands[k], 1, 0, 1});
    }
    if (earlier != 0) return;
    const auto later =
        std::find_if(bands.begin() + static_cast<std::ptrdiff_t>(b) + 1, bands.end(), is_sibling);
    if (later != bands.end()) band.siblings.push_back({&*later, 0, 0, 2});
}

/// The bands that have coefficients, with their relations.
std::vector<EmbeddedBand> prepare(std::span<const StreamBand> sources,
                                  std::span<const ParentBand> parents) {
    std::vector<EmbeddedBand> bands;
    for (const StreamBand& source : sources)
        if (source.box.count() != 0) bands.emplace_back(source, frame_of(sources, source.level));
    for (std::size_t b = 0; b < bands.size(); ++b) {
        const auto is_parent = [&](const auto& other) {
            return other.level == bands[b].source.level + 1 &&
                   other.channel == bands[b].source.channel;
        };
        for (const EmbeddedBand& other : bands)
            if (is_parent(other.source)) bands[b].parent = &other;
        for (const ParentBand& other : parents)
            if (is_parent(other)) bands[b].outer_parent = &other;
        link_siblings(bands, b);
    }
    return bands;
}

std::uint32_t all_bits(GridView<const std::int32_t> values) {
    std::uint32_t bits = 0;
    for (std::int64_t r = 0; r < values.rows; ++r)
        for (std::int64_t c = 0; c < values.cols; ++c) bits |= magnitude_of(values(r, c));
    return bits;
}

/// By how much the planes of each band fall short of those of the stream, in unary.
template <class Coder>
void code_planes(Coder& coder, std::vector<EmbeddedBand>& bands, int planes) {
    constexpr std::uint32_t kEven = 1U << 15;
    for (EmbeddedBand& band : bands) {
        int k = planes;
        while (k > 0 && !coder.code(band.planes == k, kEven)) --k;
        band.planes = k;
    }
}

/// The text of the format for every coder: see range_coder.h. Calls at_end(plane, pass).
template <int kSets, class Coder, class AtEnd>
void code_passes(Coder& coder, std::vector<EmbeddedBand>& bands, int planes, int passes,
                 double bits_per_worth, AtEnd at_end) {
    code_planes(coder, bands, planes);
    PassCoder<Coder, kSets> pass_coder(coder, bands, bits_per_worth);
    for (int n = 0; n < passes; ++n) {
        const int plane = planes - 1 - n / 3;
        const int pass = n % 3 + 1;
        pass_coder.code_pass(plane, pass);
        at_end(plane, pass);
    }
}

template <class Coder, class AtEnd>
void code_stream(Coder& coder, std::vector<EmbeddedBand>& bands, int planes, int passes,
                 const StreamOptions& options, AtEnd at_end) {
    const double bits_per_worth = kWorthUnit / options.squared_error_per_bit;
    if (options.profile == StreamProfile::Dense)
        code_passes<3>(coder, bands, planes, passes, bits_per_worth, at_end);
    else
        code_passes<1>(coder, bands, planes, passes, bits_per_worth, at_end);
}

/// Bands ready to be encoded, and the number of planes.
Result<int> count_planes(std::vector<EmbeddedBand>& bands) {
    int planes = 0;
    for (EmbeddedBand& band : bands) {
        band.planes = std::bit_width(all_bits(band.source.values));
        if (band.planes > kMostPlanes)
            return wrong_argument(band.source, "a value is -2^31; use a larger step");
        planes = std::max(planes, band.planes);
    }
    return planes;
}

}  // namespace

Result<EmbeddedStream> encode_stream(std::span<const StreamBand> sources,
                                     std::span<const ParentBand> parents,
                                     const StreamOptions& options) {
    RELIEF_CHECK(check(sources, parents));
    std::vector<EmbeddedBand> bands = prepare(sources, parents);
    EmbeddedStream stream;
    RELIEF_TRY(stream.planes, count_planes(bands));
    Thrifty<RangeEncoder> encoder;
    std::vector<CodePoint> points;
    code_stream(encoder, bands, stream.planes, 3 * stream.planes, options,
                [&](int plane, int pass) {
                    stream.ends.push_back({plane, pass, 0});
                    points.push_back(encoder.point());
                });
    stream.bytes = encoder.finish();
    for (std::size_t k = 0; k < points.size(); ++k)
        stream.ends[k].bytes = bytes_up_to(stream.bytes, points[k]);
    return stream;
}

Result<double> stream_bits(std::span<const StreamBand> sources, std::span<const ParentBand> parents,
                           const StreamOptions& options) {
    RELIEF_CHECK(check(sources, parents));
    std::vector<EmbeddedBand> bands = prepare(sources, parents);
    RELIEF_TRY(const int planes, count_planes(bands));
    Thrifty<CostCounter> counter;
    code_stream(counter, bands, planes, 3 * planes, options, [](int, int) {});
    return counter.bits();
}

Result<KnownBits> decode_stream(const StreamPart& part, std::span<const StreamBand> sources,
                                std::span<const ParentBand> parents, StreamProfile profile) {
    RELIEF_CHECK(check(sources, parents));
    if (part.planes < 0 || part.planes > kMostPlanes || part.passes < 0 ||
        part.passes > 3 * part.planes)
        return Error{ErrorCode::BadFile,
                     "claims " + std::to_string(part.passes) + " passes of " +
                         std::to_string(part.planes) + " bit planes; the file is damaged",
                     "embedded stream"};
    for (const StreamBand& source : sources)
        for (std::int64_t r = 0; r < source.box.rows; ++r)
            std::fill_n(source.values.row(r), source.box.cols, 0);
    std::vector<EmbeddedBand> bands = prepare(sources, parents);
    RangeDecoder decoder(part.bytes);
    KnownBits known{part.planes, 3};
    code_stream(decoder, bands, part.planes, part.passes, {.profile = profile},
                [&](int plane, int pass) {
                    known = {plane, pass};
                });
    return known;
}

}  // namespace relief::codec
