#pragma once

#include "relief/core/polygon_mesh.h"
#include "relief/multires/mesh_hierarchy.h"

/// Forward subdivision of meshes with all that they carry. Source: reverse-subdivision.md sections
/// 2 to 5.
namespace relief::multires {

struct PolygonSubdivision {
    int steps = 1;
    bool limit = false;  ///< vertices go to where they go in the end, with their normals there
    bool boundary_corners = false;  ///< boundary vertices of one face stay where they are
};

/// A mesh after some steps. Attributes of vertices follow like places; those of corners, and labels
/// of faces, with Loop and Catmull-Clark; normals are left out, and float32 ones are added with
/// `limit`; what is left of creases and sharp vertices is kept. Errors: those of relief::check,
/// mesh::build and Subdivider::prepare, naming the element. Complexity: O(result).
[[nodiscard]] Result<PolygonMesh> subdivide(const PolygonMesh& polygons, const MeshSpec& spec,
                                            const PolygonSubdivision& options);

}  // namespace relief::multires
