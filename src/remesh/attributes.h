#pragma once

#include "relief/core/polygon_mesh.h"
#include "remesh/moving_mesh.h"

namespace relief::remesh {

/// Gives `result`, whose vertices and faces are those of `mesh` on the surface of `source`, the
/// attributes, labels and libraries of `source` there. Values of vertices are interpolated, normals
/// made of length 1. Values of corners with seams are taken from the side of the seam that the
/// middle of the face is on, as near to the corner as that side goes. Faces are called as the
/// polygon at their middle. Complexity: O(n).
void take_attributes(const PolygonMesh& source, const MovingMesh& mesh, PolygonMesh& result);

}  // namespace relief::remesh
