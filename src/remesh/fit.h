#pragma once

#include <vector>

#include "relief/mesh/closest.h"
#include "remesh/moving_mesh.h"

namespace relief::remesh {

/// Triangles with corners on a surface lie inside its curves. This moves vertices off the surface,
/// along its normals and not those that are fixed, to where the squared distance between both is
/// least: half the root mean square on smooth surfaces. Complexity: O(n log n) a round.
void fit(MovingMesh& mesh, const mesh::TriangleTree& surface, int rounds);

}  // namespace relief::remesh
