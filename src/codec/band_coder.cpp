#include "relief/codec/band_coder.h"

#include <string>

#include "codec/level_coder.h"
#include "codec/range_coder.h"

namespace relief::codec {

namespace {

/// Median of W, N and W + N - NW: the larger neighbour below an edge, the smaller above, a plane
/// between. Outside the band: W or N alone, 0 for the first value.
std::int32_t median_edge(GridView<const std::int32_t> values, std::int64_t r, std::int64_t c) {
    if (r == 0 && c == 0) return 0;
    if (r == 0) return values(r, c - 1);
    if (c == 0) return values(r - 1, c);
    const std::int64_t w = values(r, c - 1);
    const std::int64_t n = values(r - 1, c);
    const std::int64_t plane = w + n - values(r - 1, c - 1);
    return static_cast<std::int32_t>(std::clamp(plane, std::min(w, n), std::max(w, n)));
}

/// Differences modulo 2^32, so that each is an int32 again.
Grid<std::int32_t> residuals(GridView<const std::int32_t> values) {
    Grid<std::int32_t> out(values.rows, values.cols);
    for (std::int64_t r = 0; r < values.rows; ++r)
        for (std::int64_t c = 0; c < values.cols; ++c)
            out(r, c) =
                static_cast<std::int32_t>(static_cast<std::uint32_t>(values(r, c)) -
                                          static_cast<std::uint32_t>(median_edge(values, r, c)));
    return out;
}

void add_predictions(GridView<std::int32_t> values) {
    for (std::int64_t r = 0; r < values.rows; ++r)
        for (std::int64_t c = 0; c < values.cols; ++c)
            values(r, c) =
                static_cast<std::int32_t>(static_cast<std::uint32_t>(values(r, c)) +
                                          static_cast<std::uint32_t>(median_edge(values, r, c)));
}

/// The text of the format for every coder: see range_coder.h. False: the bytes ran out.
template <class Coder>
bool code_level(Coder& coder, std::span<const BandView> bands, std::span<const BandView> parents) {
    LevelCoder<Coder> level(coder, parents);
    for (const BandView& band : bands) {
        if (Coder::kDecodes || !band.predict) {
            if (!level.code_band(band.box, band.values, band.predict)) return false;
            if (band.predict) add_predictions(band.values);
        } else {
            Grid<std::int32_t> differences = residuals(band.values);
            level.code_band(band.box, differences.view(), true);
        }
    }
    return true;
}

bool fits(const BandView& band) {
    return band.box.rows >= 0 && band.box.cols >= 0 && band.values.rows == band.box.rows &&
           band.values.cols == band.box.cols;
}

}  // namespace

std::vector<std::uint8_t> encode_level(std::span<const BandView> bands,
                                       std::span<const BandView> parents) {
    RangeEncoder encoder;
    code_level(encoder, bands, parents);
    return encoder.finish();
}

double level_bits(std::span<const BandView> bands, std::span<const BandView> parents) {
    CostCounter counter;
    code_level(counter, bands, parents);
    return counter.bits();
}

Status decode_level(std::span<const std::uint8_t> bytes, std::span<BandView> bands,
                    std::span<const BandView> parents) {
    if (!std::all_of(bands.begin(), bands.end(), fits) ||
        !std::all_of(parents.begin(), parents.end(), fits))
        return Error{ErrorCode::InvalidArgument, "a band's values have not the size of its box",
                     "level data"};
    if (!parents.empty() && parents.size() != bands.size())
        return Error{ErrorCode::InvalidArgument, "give a parent for each band, or none at all",
                     "level data"};
    RangeDecoder decoder(bytes);
    if (!code_level(decoder, bands, parents) || !decoder.at_end())
        return Error{ErrorCode::BadFile,
                     "does not end where its bands end; the file is damaged or cut off",
                     "level data of " + std::to_string(bytes.size()) + " bytes"};
    return {};
}

}  // namespace relief::codec
