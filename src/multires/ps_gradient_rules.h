#pragma once

#include <span>

#include "multires/ps_rings.h"
#include "relief/core/vec2.h"

namespace relief::multires::ps {

/// Of the quadratic through a vertex with weights 1 / distance^2 (powell-sabin.md section 12,
/// option `quadratic`), or of a plane where the points do not determine one.
[[nodiscard]] Vec2 quadratic_gradient(const mesh::Triangulation& mesh,
                                      std::span<const double> values, mesh::Index v,
                                      StencilSearch& search);

}  // namespace relief::multires::ps
