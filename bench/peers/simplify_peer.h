#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "relief/core/polygon_mesh.h"
#include "relief/core/result.h"

/// Libraries that simplify meshes of triangles.
namespace relief::peers {

/// Meshes with about so many faces, or as few as the library comes to. Requires: each number is
/// smaller than the one before. Errors: BadInput when the library refuses the mesh.
using Simplified = Result<std::vector<PolygonMesh>>;

/// By error quadrics; no face turns over, and vertices of boundaries stay.
[[nodiscard]] Simplified openmesh_simplified(const PolygonMesh& mesh,
                                             std::span<const std::int64_t> faces);

/// By volumes, boundaries and shapes of triangles, as Lindstrom and Turk do.
[[nodiscard]] Simplified cgal_simplified(const PolygonMesh& mesh,
                                         std::span<const std::int64_t> faces);

}  // namespace relief::peers
