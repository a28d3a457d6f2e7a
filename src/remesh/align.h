#pragma once

#include "relief/multires/mesh_hierarchy.h"
#include "remesh/moving_mesh.h"

namespace relief::remesh {

/// Moves vertices along the surface to where the details of the transform that codes the mesh point
/// along normals, but those on curves: each round goes to what a synthesis without tangential
/// details gives, and back to the surface.
/// Source: mesh-codec-and-remesh.md section 3.6. Errors: those of MeshMaps::create.
/// Complexity: O(n) a round.
[[nodiscard]] Status align(MovingMesh& mesh, const multires::MeshHierarchy& hierarchy, int rounds);

/// The root mean square of the tangential parts of details, over all steps.
[[nodiscard]] Result<double> tangential_rms(const MovingMesh& mesh,
                                            const multires::MeshHierarchy& hierarchy);

}  // namespace relief::remesh
