#pragma once

#include <vector>

#include "remesh/moving_mesh.h"

namespace relief::remesh {

/// The curvature of a surface at its vertices, largest over directions, smoothed, in units of its
/// median and between 0.3 and 20: where vertices are to be close. Source: mesh-codec-and-remesh.md
/// section 3.5. Complexity: O(n).
[[nodiscard]] std::vector<double> relative_curvature(const Surface& surface);

/// How far each vertex of the surface is from a mesh on it, and from which face.
struct Reverse {
    std::vector<double> distances;
    std::vector<mesh::Index> faces;
};
[[nodiscard]] Reverse distances_from(const MovingMesh& mesh);

/// How far the surface is from the faces at each vertex of a mesh on it, measured at the vertices
/// of the surface and the centroids of the faces. tree: of the surface.
[[nodiscard]] std::vector<double> errors_at_vertices(const MovingMesh& mesh,
                                                     const mesh::TriangleTree& tree);

/// Moves vertices to the centroids of the faces around them, which weigh what their area and the
/// square of the curvature say. In long relaxations they also weigh more where the surface is far
/// from the mesh. Source: section 3.5. Complexity: O(n) a round, and O(n log n) every fifth.
void relax(MovingMesh& mesh, const std::vector<double>& curvature, const mesh::TriangleTree& tree,
           int rounds);

}  // namespace relief::remesh
