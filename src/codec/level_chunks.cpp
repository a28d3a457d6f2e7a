#include "codec/level_chunks.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "codec/bytes.h"
#include "relief/codec/band_coder.h"

namespace relief::codec {

namespace {

/// The bands of a chunk, each component apart, channels outermost.
std::vector<std::size_t> bands_of(const multires::PyramidLayout& layout, int number) {
    std::vector<std::size_t> bands;
    for (std::size_t k = 0; k < layout.bands.size(); ++k)
        if (chunk_of(layout, layout.bands[k]) == number) bands.push_back(k);
    return bands;
}

void add_views(const multires::PyramidLayout& layout, std::size_t band, const Quantised& quantised,
               bool predict, std::vector<BandView>& views) {
    for (const Grid<std::int32_t>& plane : quantised.values[band])
        // The coder writes through views only when it decodes.
        views.push_back(
            {layout.bands[band].box,
             {const_cast<std::int32_t*>(plane.row(0)), plane.rows(), plane.cols(), plane.stride()},
             predict});
}

std::vector<BandView> views_of(const multires::PyramidLayout& layout, int number,
                               const Quantised& quantised) {
    std::vector<BandView> views;
    for (const std::size_t k : bands_of(layout, number))
        add_views(layout, k, quantised, number == 0, views);
    return views;
}

/// The views of the next coarser details of the same channels; none above the coarsest.
std::vector<BandView> parents_of(const multires::PyramidLayout& layout, int number,
                                 const Quantised& quantised) {
    std::vector<BandView> views;
    if (number < 2) return views;
    const std::vector<std::size_t> coarser = bands_of(layout, number - 1);
    for (const std::size_t k : bands_of(layout, number)) {
        const auto parent = std::find_if(coarser.begin(), coarser.end(), [&](std::size_t other) {
            return layout.bands[other].channel == layout.bands[k].channel;
        });
        if (parent != coarser.end()) add_views(layout, *parent, quantised, false, views);
    }
    return views;
}

}  // namespace

int chunk_of(const multires::PyramidLayout& layout, const multires::BandLayout& band) {
    return band.channel == 0 ? 0 : layout.levels() - band.level + 1;
}

std::vector<std::uint8_t> write_level(const multires::PyramidLayout& layout,
                                      const Quantised& quantised, int number) {
    ByteWriter out;
    for (const std::size_t k : bands_of(layout, number)) out.f32(quantised.steps[k]);
    out.bytes(
        encode_level(views_of(layout, number, quantised), parents_of(layout, number, quantised)));
    return out.take();
}

Status read_level(std::span<const std::uint8_t> bytes, int number,
                  const multires::PyramidLayout& layout, Quantised& quantised) {
    quantised.values.resize(layout.bands.size());
    quantised.steps.resize(layout.bands.size(), 0);
    ByteReader in(bytes);
    for (const std::size_t k : bands_of(layout, number)) {
        const float step = in.f32();
        if (in.failed() || !std::isfinite(step) || !(step > 0))
            return Error{ErrorCode::BadFile, "a quantiser step is damaged",
                         "level chunk " + std::to_string(number)};
        quantised.steps[k] = step;
        quantised.values[k].clear();
        for (int c = 0; c < layout.components; ++c)
            quantised.values[k].emplace_back(layout.bands[k].box.rows, layout.bands[k].box.cols);
    }
    std::vector<BandView> views = views_of(layout, number, quantised);
    return decode_level(in.rest(), views, parents_of(layout, number, quantised));
}

}  // namespace relief::codec
