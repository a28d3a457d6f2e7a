#pragma once

#include "relief/multires/ps_space.h"

namespace relief::multires::ps {

/// The control triangles of smallest area. Errors: `degenerate_hull`.
[[nodiscard]] Result<std::vector<TriangleCorners>> smallest_controls(
    const mesh::Triangulation& mesh, const Split& split);

/// The points of triangle t that the control triangle of its corner k must contain, relative to the
/// corner: halfway to Z and to R of the edges k and k - 1.
[[nodiscard]] inline std::array<Vec2, 3> halfway_points(const mesh::Triangulation& mesh,
                                                        const Split& split, mesh::Index t,
                                                        mesh::Index k) {
    const auto v = mesh.corners(t);
    const mesh::Index next = k == 2 ? 0 : k + 1;
    const mesh::Index before = k == 0 ? 2 : k - 1;
    return {0.5 * (split.centre[t] - v[k]),
            0.5 * (1 - corner_weight(mesh, split, t, k)) * (v[next] - v[k]),
            0.5 * corner_weight(mesh, split, t, before) * (v[before] - v[k])};
}

}  // namespace relief::multires::ps
