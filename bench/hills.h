#pragma once

#include <cmath>

#include "relief/core/raster.h"

namespace relief::bench {

/// Hills of many sizes.
inline Raster hills(std::int64_t side) {
    Raster raster;
    raster.rows = side;
    raster.cols = side;
    Grid<double> plane(side, side);
    for (std::int64_t r = 0; r < side; ++r)
        for (std::int64_t c = 0; c < side; ++c) {
            const auto x = static_cast<double>(r);
            const auto y = static_cast<double>(c);
            double height = 0;
            for (double size = 512; size >= 2; size /= 2)
                height += size * std::sin(x / size + std::cos(y / size)) *
                          std::cos(y / size - x / size / 3);
            plane(r, c) = static_cast<float>(height);
        }
    raster.planes.push_back(std::move(plane));
    return raster;
}

}  // namespace relief::bench
