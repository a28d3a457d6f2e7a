#pragma once

#include <span>
#include <string>

#include "relief/mesh/quadrangulation.h"

/// The checks of `build` that look at more than one element.
namespace relief::mesh {

[[nodiscard]] Error bad_mesh(std::string message, const char* element, std::size_t number);

/// Requires: finite vertices, indices in range.
[[nodiscard]] Status check_convex(const Quadrangulation& mesh);
[[nodiscard]] Status check_vertices_used(const Quadrangulation& mesh);
[[nodiscard]] Status check_t_junctions(const Quadrangulation& mesh);
[[nodiscard]] Status check_overlap(const Quadrangulation& mesh);

}  // namespace relief::mesh
