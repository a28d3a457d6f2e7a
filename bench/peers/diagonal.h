#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "relief/core/polygon_mesh.h"

namespace relief::peers {

/// Of the box around the vertices. Requires: there are some.
[[nodiscard]] inline double diagonal_of(const PolygonMesh& mesh) {
    std::array<double, 3> low = mesh.vertices.at(0);
    std::array<double, 3> high = low;
    for (const auto& v : mesh.vertices)
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], v[k]);
            high[k] = std::max(high[k], v[k]);
        }
    return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

}  // namespace relief::peers
