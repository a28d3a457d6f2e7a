#pragma once

#include <span>

#include "relief/mesh/triangulation.h"

/// The checks of `build` that look at geometry.
namespace relief::mesh {

/// Twice the area of a triangle must be more than this times its squared longest side.
inline constexpr double kThinnest = 1e-12;

/// Require: finite vertices, indices in range.
[[nodiscard]] Status check_thickness(const Triangulation& mesh);
/// Require: connected, triangles counter-clockwise.
[[nodiscard]] Status check_folds(const Triangulation& mesh);
[[nodiscard]] Status check_hanging_vertices(const Triangulation& mesh);
[[nodiscard]] Status check_overlap(const Triangulation& mesh);

}  // namespace relief::mesh
