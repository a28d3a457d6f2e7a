#include "codec/tile_details.h"

#include <algorithm>
#include <utility>

#include "codec/embedded_quantiser.h"
#include "codec/pyramid_search.h"
#include "relief/codec/fill.h"

namespace relief::codec {

namespace {

using multires::Planes;

/// How much more of the raster is looked at around a tile: 8 units, over which what happens beyond
/// decays to 3 10^-5.
constexpr std::int64_t kMargin = 8 * kUnit;

/// The surface of the coarser levels alone, on a block's window.
Planes<double> surface_below(const Block& block, const Planes<double>& below,
                             const multires::PyramidLayout& fine) {
    auto pyramid = Pyramid<double>::allocate(fine);
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
        for (std::size_t c = 0; c < pyramid.bands[k].size(); ++c) {
            Grid<double>& plane = pyramid.bands[k][c];
            for (std::int64_t r = 0; r < plane.rows(); ++r)
                if (k > 0)
                    std::fill_n(plane.row(r), plane.cols(), 0.0);
                else
                    std::copy_n(below[c].row((block.window.row0 >> kFine) + r) +
                                    (block.window.col0 >> kFine),
                                plane.cols(), plane.row(r));
        }
    return multires::synthesise(pyramid);
}

void subtract(const Planes<double>& what, Planes<double>& from) {
    for (std::size_t c = 0; c < from.size(); ++c)
        for (std::int64_t r = 0; r < from[c].rows(); ++r)
            for (std::int64_t k = 0; k < from[c].cols(); ++k) from[c](r, k) -= what[c](r, k);
}

/// Band k of a block's pyramid: the core's part, into the band of the raster's layout.
void quantise_core(const Block& block, const Pyramid<double>& details, std::size_t k,
                   const multires::PyramidLayout& layout, const PyramidCoding& coding,
                   QuantisedPyramid& out) {
    const std::size_t band = coarse_bands(layout) - 1 + k;
    const int level = layout.bands[band].level;
    const LatticeBox part =
        lattice_of(block, level, {0, 0, layout.rows, layout.cols}, layout.bands[band].box);
    const LatticeBox local = relative(part, block.window.row0 >> level, block.window.col0 >> level);
    out.boxes[band] = part;
    for (const Grid<double>& plane : details.bands[k]) {
        auto& values = out.values[band].emplace_back(part.rows, part.cols);
        auto& worths = out.worths[band].emplace_back(part.rows, part.cols);
        if (part.count() == 0) continue;
        quantise_band<double>(part_of(plane.view(), local), coding.step_of(layout, band),
                              values.view(), worths.view());
    }
}

}  // namespace

std::vector<Block> blocks_of(const TileTree& tree) {
    const LatticeBox raster{0, 0, tree.tier(0).rows, tree.tier(0).cols};
    std::vector<Block> blocks;
    for (std::int64_t tile = 0; tile < tree.tier(0).tiles(); ++tile) {
        const LatticeBox core = tree.box(0, tile);
        const LatticeBox around{core.row0 - kMargin, core.col0 - kMargin, core.rows + 2 * kMargin,
                                core.cols + 2 * kMargin};
        blocks.push_back({tile, core, intersection(around, raster)});
    }
    return blocks;
}

LatticeBox lattice_of(const Block& block, int level, const LatticeBox& raster,
                      const LatticeBox& all) {
    const LatticeBox& core = block.core;
    const auto end = [&](std::int64_t last, std::int64_t size, std::int64_t whole) {
        return last == size ? whole : last >> level;
    };
    const std::int64_t row0 = core.row0 >> level;
    const std::int64_t col0 = core.col0 >> level;
    const LatticeBox part{row0, col0,
                          end(core.row0 + core.rows, raster.rows, all.row0 + all.rows) - row0,
                          end(core.col0 + core.cols, raster.cols, all.col0 + all.cols) - col0};
    return intersection(part, all);
}

Target Window::target() const {
    Target target;
    for (const Grid<double>& plane : filled) target.planes.push_back(plane.view());
    if (!samples.mask.empty()) target.mask = samples.mask.view();
    return target;
}

Result<Window> read_window(const RasterSource& source, const LatticeBox& box) {
    Window window;
    RELIEF_TRY(window.samples, source.read(box));
    window.samples.rows = box.rows;
    window.samples.cols = box.cols;
    const bool empty = window.samples.valid_count() == 0;
    for (const Grid<double>& plane : window.samples.planes)
        window.filled.push_back(empty ? Grid<double>(box.rows, box.cols, 0.0)
                                      : filled(plane.view(), window.samples.mask));
    return window;
}

Result<multires::PyramidLayout> fine_layout(const multires::PyramidLayout& layout,
                                            const LatticeBox& window) {
    multires::SchemeSpec spec = layout.spec;
    spec.levels = kFine;
    return multires::layout(spec, window.rows, window.cols, layout.components);
}

std::size_t coarse_bands(const multires::PyramidLayout& layout) {
    return layout.bands.size() - 3 * kFine;
}

Result<QuantisedPyramid> choose_details(const RasterSource& source,
                                        const multires::PyramidLayout& layout, const Block& block,
                                        const CoarserLevels& coarser) {
    RELIEF_TRY(Window window, read_window(source, block.window));
    RELIEF_TRY(const multires::PyramidLayout fine, fine_layout(layout, block.window));
    RELIEF_TRY(Pyramid<double> exact, multires::analyse<double>(window.target().planes, fine.spec));
    const bool over = coarser.effort != Effort::Select;
    if (over) {
        subtract(surface_below(block, coarser.surface, fine), window.filled);
        for (Grid<double>& plane : exact.bands[0])
            plane = Grid<double>(plane.rows(), plane.cols(), 0.0);
    }
    const Pyramid<double> details =
        improved(std::move(exact), window.target(), coarser.coding, coarser.effort, over);
    QuantisedPyramid result;
    result.boxes.resize(layout.bands.size());
    result.values.resize(layout.bands.size());
    result.worths.resize(layout.bands.size());
    for (std::size_t k = 1; k < details.bands.size(); ++k)
        quantise_core(block, details, k, layout, coarser.coding, result);
    for (std::size_t k = 0; k < coarse_bands(layout); ++k) result.values[k].emplace_back();
    return result;
}

}  // namespace relief::codec
