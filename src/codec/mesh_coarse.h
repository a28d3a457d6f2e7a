#pragma once

#include "codec/mesh_order.h"
#include "relief/core/polygon_mesh.h"

namespace relief::codec {

/// The attributes and labels of a coarser level: of vertices, those of the vertices that they
/// became; of corners, those of the finest corners at the same vertex and in the same face; of
/// faces, those of the finest face at their first corner.
///
/// sqrt(3) cuts triangles into nine every second step. An odd number of steps above the finest
/// level no face lies in a single one: corners have what they have in the level between, where a
/// face of three that lie half within it stands for each; faces that a seam crosses have no
/// elements. fine: in the numbers of `order`. coarse: its vertices and polygons are those of depth
/// `depth`. Complexity: O(coarse x steps + elements); sqrt(3) O(finest mesh).
void take_coarse_extras(const PolygonMesh& fine, const MeshOrder& order,
                        const MeshHierarchy& hierarchy, int depth, PolygonMesh& coarse);

}  // namespace relief::codec
