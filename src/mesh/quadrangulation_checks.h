#pragma once

#include "relief/mesh/quadrangulation.h"

/// The checks of `build` that look at more than one element.
namespace relief::mesh {

/// Requires: finite vertices, indices in range.
[[nodiscard]] Status check_convex(const Quadrangulation& mesh);
[[nodiscard]] Status check_vertices_used(const Quadrangulation& mesh);
[[nodiscard]] Status check_t_junctions(const Quadrangulation& mesh);
[[nodiscard]] Status check_overlap(const Quadrangulation& mesh);

}  // namespace relief::mesh
