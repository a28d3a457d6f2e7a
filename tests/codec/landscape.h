#pragma once

#include <cmath>

#include "relief/core/raster.h"
#include "support.h"

namespace relief::codec {

/// Terrain: noise on lattices of spacing 2^k, larger on coarser ones, interpolated.
inline Raster landscape(std::int64_t rows, std::int64_t cols, int components = 1) {
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    raster.type = SampleType::Float32;
    for (int p = 0; p < components; ++p) {
        Grid<double> plane(rows, cols, 900.0);
        for (int k = 0; k < 8; ++k) {
            const auto nodes =
                test::noise_grid<double>((rows >> k) + 2, (cols >> k) + 2, 9 * k + p);
            const double height = 3 * std::pow(1.7, k);
            for (std::int64_t r = 0; r < rows; ++r)
                for (std::int64_t c = 0; c < cols; ++c) {
                    const double y = std::ldexp(double(r), -k) - double(r >> k);
                    const double x = std::ldexp(double(c), -k) - double(c >> k);
                    const auto along = [&](std::int64_t i) {
                        return (1 - x) * nodes(i, c >> k) + x * nodes(i, (c >> k) + 1);
                    };
                    plane(r, c) += height * ((1 - y) * along(r >> k) + y * along((r >> k) + 1));
                }
        }
        for (std::int64_t r = 0; r < rows; ++r)
            for (std::int64_t c = 0; c < cols; ++c) plane(r, c) = static_cast<float>(plane(r, c));
        raster.planes.push_back(std::move(plane));
    }
    return raster;
}

}  // namespace relief::codec
