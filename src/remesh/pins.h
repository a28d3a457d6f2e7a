#pragma once

#include <span>
#include <vector>

#include "remesh/moving_mesh.h"

namespace relief::remesh {

/// Vertices of the surface that are farther from a mesh than a tolerance, the farthest first, at
/// most `most`; each keeps others away that are near it.
[[nodiscard]] std::vector<mesh::Index> far_vertices(const Surface& surface,
                                                    std::span<const double> distances,
                                                    double tolerance, double apart,
                                                    std::size_t most);

/// Puts vertices of the mesh onto those of the surface that are farther away than the tolerance,
/// where no face flips, and fixes them there. Returns how many. Complexity: O(n log n).
std::size_t pin_far_vertices(MovingMesh& mesh, double tolerance);

/// Moves vertices of faces that are farther from the surface than the tolerance to where the
/// farthest of the faces around them is nearer. tree: of the surface. Complexity: O(n log n).
void draw_near(MovingMesh& mesh, const mesh::TriangleTree& tree, double tolerance);

}  // namespace relief::remesh
