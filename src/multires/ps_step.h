#pragma once

#include "relief/multires/ps_refine.h"

namespace relief::multires::ps {

/// The coarse vertices on which a fine vertex depends: itself; the corners of its triangle; or the
/// ends of its edge, the nearer first.
struct StepStencil {
    int count = 0;
    std::array<mesh::Index, 3> vertex{};
};
[[nodiscard]] StepStencil step_stencil(const Space& coarse, Scheme scheme, mesh::Index fine);

/// Three points of the tangent plane at a new vertex, relative to it.
struct Anchors {
    TriangleCorners point;
    Heights height{};
};
/// From the tangent planes at the vertices of the stencil. `position`: of the fine vertex; `kappa`:
/// of the coarse ones. Requires: not an old vertex.
[[nodiscard]] Anchors anchors(const Space& coarse, Scheme scheme, std::span<const double> kappa,
                              mesh::Index fine, Vec2 position,
                              const std::array<spline::TangentPlane, 3>& planes);

}  // namespace relief::multires::ps
