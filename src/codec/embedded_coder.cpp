#include "codec/embedded_coder.h"

#include <bit>
#include <string>

#include "codec/embedded_pass.h"

namespace relief::codec {

namespace {

LatticeBox frame_of(std::span<const StreamBand> bands, int level) {
    std::int64_t r0 = INT64_MAX, c0 = INT64_MAX, r1 = INT64_MIN, c1 = INT64_MIN;
    for (const StreamBand& b : bands) {
        if (b.level != level || b.box.count() == 0) continue;
        r0 = std::min(r0, b.box.row0);
        c0 = std::min(c0, b.box.col0);
        r1 = std::max(r1, b.box.row0 + b.box.rows);
        c1 = std::max(c1, b.box.col0 + b.box.cols);
    }
    if (r0 > r1) return {};
    r0 &= ~std::int64_t{1};
    c0 &= ~std::int64_t{1};
    return {r0, c0, r1 - r0, c1 - c0};
}

std::vector<EmbeddedBand> prepare(std::span<const StreamBand> bands,
                                  std::span<const ParentBand> parents) {
    std::vector<EmbeddedBand> result;
    for (const StreamBand& b : bands)
        if (b.box.count()) result.emplace_back(b, frame_of(bands, b.level));
    for (EmbeddedBand& b : result) {
        for (const ParentBand& q : parents)
            if (q.level == b.source.level + 1 && q.channel == b.source.channel) b.parent_values = q;
        for (EmbeddedBand& q : result) {
            if (q.source.level == b.source.level + 1 && q.source.channel == b.source.channel)
                b.parent_band = &q;
            if (q.source.level == b.source.level &&
                (q.source.channel == 1 || q.source.channel == 2))
                b.siblings[static_cast<std::size_t>(q.source.channel - 1)] = &q;
        }
    }
    return result;
}

int planes_of(GridView<const std::int32_t> values) {
    std::uint32_t all = 0;
    for (std::int64_t r = 0; r < values.rows; ++r)
        for (std::int64_t c = 0; c < values.cols; ++c) all |= magnitude_of(values(r, c));
    return std::bit_width(all);
}

}  // namespace

Result<EmbeddedStream> encode_stream(std::span<const StreamBand> bands,
                                     std::span<const ParentBand> parents,
                                     const StreamOptions& options) {
    EmbeddedStream stream;
    std::vector<EmbeddedBand> work = prepare(bands, parents);
    for (EmbeddedBand& b : work)
        b.planes = planes_of(b.source.values), stream.planes = std::max(stream.planes, b.planes);
    Thrifty<RangeEncoder> encoder;
    for (EmbeddedBand& b : work) {
        for (int k = b.planes; k < stream.planes; ++k) encoder.code(false, 32768);
        if (b.planes) encoder.code(true, 32768);
    }
    StreamCoder<Thrifty<RangeEncoder>, 3> coder(encoder, work, 1 / options.squared_error_per_bit);
    std::vector<CodePoint> points;
    for (int p = stream.planes - 1; p >= 0; --p)
        for (int pass = 1; pass <= 3; ++pass) {
            coder.code_pass(p, pass);
            stream.ends.push_back({p, pass, 0});
            points.push_back(encoder.point());
        }
    stream.bytes = encoder.finish();
    for (std::size_t k = 0; k < points.size(); ++k)
        stream.ends[k].bytes = static_cast<std::uint32_t>(bytes_up_to(stream.bytes, points[k]));
    return stream;
}

Result<double> stream_bits(std::span<const StreamBand> bands, std::span<const ParentBand> parents,
                           const StreamOptions& options) {
    std::vector<EmbeddedBand> work = prepare(bands, parents);
    int planes = 0;
    for (EmbeddedBand& b : work)
        b.planes = planes_of(b.source.values), planes = std::max(planes, b.planes);
    Thrifty<CostCounter> encoder;
    for (EmbeddedBand& b : work) {
        for (int k = b.planes; k < planes; ++k) encoder.code(false, 32768);
        if (b.planes) encoder.code(true, 32768);
    }
    StreamCoder<Thrifty<CostCounter>, 3> coder(encoder, work, 1 / options.squared_error_per_bit);
    for (int p = planes - 1; p >= 0; --p)
        for (int pass = 1; pass <= 3; ++pass) coder.code_pass(p, pass);
    return encoder.bits();
}

Result<KnownBits> decode_stream(const StreamPart& part, std::span<const StreamBand> bands,
                                std::span<const ParentBand> parents, StreamProfile) {
    for (const StreamBand& b : bands)
        for (std::int64_t r = 0; r < b.box.rows; ++r) std::fill_n(b.values.row(r), b.box.cols, 0);
    std::vector<EmbeddedBand> work = prepare(bands, parents);
    RangeDecoder decoder(part.bytes);
    for (EmbeddedBand& b : work) {
        int k = part.planes;
        while (k > 0 && !decoder.code(false, 32768)) --k;
        b.planes = k;
    }
    StreamCoder<RangeDecoder, 3> coder(decoder, work, 0);
    KnownBits known{part.planes, 3};
    for (int n = 0; n < part.passes; ++n) {
        known = {part.planes - 1 - n / 3, n % 3 + 1};
        coder.code_pass(known.plane, known.pass);
    }
    return known;
}

}  // namespace relief::codec
