#pragma once

#include "multires/cubic_level.h"
#include "relief/multires/pyramid.h"

/// Sizes and places in a pyramid of scheme `cubic`.
namespace relief::multires::cubic {

/// Sides of a lattice.
struct Lattice {
    std::int64_t rows = 0;
    std::int64_t cols = 0;
};

/// The lattice of a level: every 2^level-th sample of the raster.
inline Lattice lattice_at(const PyramidLayout& layout, int level) {
    const std::int64_t step = std::int64_t{1} << level;
    return {(layout.rows + step - 1) / step, (layout.cols + step - 1) / step};
}

/// Where the details of a level stand among the bands; channel 1 .. 3.
inline std::size_t band_of(const PyramidLayout& layout, int level, int channel) {
    return static_cast<std::size_t>(3 * (layout.levels() - level) + channel);
}

/// All pairs of a fine lattice.
inline Window whole(const Lattice& fine) {
    return {{fine.rows, {0, (fine.rows + 1) / 2}}, {fine.cols, {0, (fine.cols + 1) / 2}}};
}

}  // namespace relief::multires::cubic
