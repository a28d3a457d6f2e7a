#pragma once

#include <string_view>
#include <vector>

#include "relief/core/polygon_mesh.h"
#include "relief/core/result.h"

namespace relief::io {

/// "cube", "octahedron", "icosahedron", "torus".
[[nodiscard]] std::vector<std::string_view> synthetic_mesh_names();

/// The polyhedron of that name, with corners at distance 1 from its centre or, for the cube,
/// coordinates -1 and 1; or a torus of `size` x 2 size quads around the z axis, with radii 3 and 1.
/// Faces are counter-clockwise from outside. Errors: InvalidArgument for other names, and sizes of
/// the torus beyond 3 .. 8192.
[[nodiscard]] Result<PolygonMesh> synthetic_mesh(std::string_view name, int size);

}  // namespace relief::io
