#pragma once

#include <optional>

#include "relief/mesh/triangulation.h"

/// The checks of `build` that look at geometry.
namespace relief::mesh {

/// Require: finite vertices, indices in range. The first triangle of which twice the area is at
/// most 1e-12 times the squared longest side.
[[nodiscard]] std::optional<Index> find_thin_triangle(const Triangulation& mesh);
[[nodiscard]] Status check_thickness(const Triangulation& mesh);
/// Require: connected, triangles counter-clockwise.
[[nodiscard]] Status check_folds(const Triangulation& mesh);
[[nodiscard]] Status check_hanging_vertices(const Triangulation& mesh);
[[nodiscard]] Status check_overlap(const Triangulation& mesh);

}  // namespace relief::mesh
