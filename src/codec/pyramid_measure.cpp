#include "codec/pyramid_measure.h"

#include <algorithm>

#include "codec/pyramid_search.h"
#include "relief/codec/raster_codec.h"
#include "relief/multires/cubic_window.h"

namespace relief::codec {

namespace {

using multires::Planes;

/// The raster's description with the samples of a window.
Result<Raster> read_part(const Reference& reference, const LatticeBox& window) {
    if (reference.cancelled && reference.cancelled()) return cancelled_error();
    const RasterSource& source = reference.source;
    RELIEF_TRY(Raster samples, source.read(window));
    Raster part = description_of(source.description());
    part.rows = window.rows;
    part.cols = window.cols;
    part.planes = std::move(samples.planes);
    part.mask = std::move(samples.mask);
    return part;
}

/// Every 2^level-th sample of a window of the raster.
Raster picked(const Raster& part, const LatticeBox& window, const LatticeBox& coarse, int level) {
    Raster result = description_of(part);
    result.rows = coarse.rows;
    result.cols = coarse.cols;
    const auto pick = [&](const auto& from, auto& to) {
        for (std::int64_t r = 0; r < coarse.rows; ++r)
            for (std::int64_t c = 0; c < coarse.cols; ++c)
                to(r, c) = from(((coarse.row0 + r) << level) - window.row0,
                                ((coarse.col0 + c) << level) - window.col0);
    };
    for (const Grid<double>& plane : part.planes)
        pick(plane, result.planes.emplace_back(coarse.rows, coarse.cols));
    if (!part.mask.empty()) {
        result.mask = Grid<std::uint8_t>(coarse.rows, coarse.cols);
        pick(part.mask, result.mask);
    }
    return result;
}

/// The surface without details of `finest` and finer ones, on a window of the lattice of `level`.
Result<Planes<double>> surface(const multires::PyramidLayout& layout, const PyramidBlocks& blocks,
                               int level, const LatticeBox& window, int finest) {
    const auto boxes = multires::cubic::needed_boxes(layout, level, window);
    RELIEF_TRY(const PyramidPart part, blocks.read(boxes, finest));
    return cubic_surface(layout, level, window, part);
}

void add(SurfaceError& sum, const SurfaceError& error) {
    sum.max = std::max(sum.max, error.max);
    sum.square += error.square;
}

}  // namespace

Result<SurfaceError> measured(const Reference& reference,
                              const std::shared_ptr<const ByteSource>& file,
                              std::uint64_t visible) {
    RELIEF_TRY(const RasterFile opened, RasterFile::open(file, visible));
    SurfaceError all;
    for (const LatticeBox& window : reference.windows) {
        RELIEF_TRY(const Raster part, read_part(reference, window));
        RELIEF_TRY(const DecodedRaster decoded, opened.decode_window(0, window));
        if (!decoded.damaged.empty())
            return Error{ErrorCode::BadFile,
                         "what was encoded can not be decoded; nothing was written. Please report "
                         "this",
                         "verification"};
        add(all, surface_error(part, decoded.raster.planes));
    }
    return all;
}

Result<LevelErrors> measured_levels(const Reference& reference,
                                    const multires::PyramidLayout& layout,
                                    const PyramidBlocks& blocks) {
    LevelErrors errors;
    errors.largest.resize(static_cast<std::size_t>(layout.levels()));
    for (const LatticeBox& window : reference.windows) {
        RELIEF_TRY(const Raster part, read_part(reference, window));
        for (int level = 1; level <= layout.levels(); ++level) {
            RELIEF_TRY(const Planes<double> fine, surface(layout, blocks, 0, window, level));
            SurfaceError error = surface_error(part, fine);
            if (level == layout.levels()) errors.coarsest_square += error.square;
            const LatticeBox coarse = box_at_level(window, level);
            if (coarse.count() > 0) {
                RELIEF_TRY(const Planes<double> planes,
                           surface(layout, blocks, level, coarse, level));
                add(error, surface_error(picked(part, window, coarse, level), planes));
            }
            double& largest = errors.largest[static_cast<std::size_t>(level - 1)];
            largest = std::max(largest, error.max);
        }
    }
    return errors;
}

}  // namespace relief::codec
