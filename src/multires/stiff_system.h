#pragma once

#include <vector>

#include "multires/conjugate_gradient.h"
#include "relief/multires/mesh_step.h"

namespace relief::multires {

/// Solves 3 x_v + (sum of x over the stiff neighbours of v) = known_v for all stiff vertices v; the
/// smallest solution where there are several. Source: reverse-subdivision.md, equation (4).
template <class T>
[[nodiscard]] std::vector<Vec3<T>> solve_stiff_system(const StiffVertices& stiff,
                                                      const std::vector<Vec3<T>>& known) {
    return conjugate_gradient<T>(known,
                                 [&](const std::vector<Vec3<T>>& x, std::vector<Vec3<T>>& y) {
                                     for (std::size_t k = 0; k < x.size(); ++k) {
                                         y[k] = T{3} * x[k];
                                         for (const mesh::Index w : stiff.neighbours[k])
                                             if (w != mesh::kNone) y[k] += x[w];
                                     }
                                 });
}

}  // namespace relief::multires
