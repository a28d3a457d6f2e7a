#pragma once

#include "codec/mesh_order.h"
#include "relief/core/polygon_mesh.h"

namespace relief::codec {

/// The attributes and labels of a coarser level: of vertices, those of the vertices that they
/// became; of corners, those of the finest corners at the same vertex and in the same face; of
/// faces, those of the finest face at their first corner. sqrt(3) has no such corners and faces,
/// and attributes of vertices only. fine: in the numbers of `order`. coarse: its vertices and
/// polygons are those of depth `depth`. Complexity: O(coarse x steps + elements).
void take_coarse_extras(const PolygonMesh& fine, const MeshOrder& order,
                        const MeshHierarchy& hierarchy, int depth, PolygonMesh& coarse);

}  // namespace relief::codec
