#pragma once

#include <span>
#include <vector>

#include "edit/vertex_faces.h"
#include "relief/multires/mesh_step.h"

namespace relief::edit {

/// Some faces of a mesh as a mesh of their own. Vertices, faces and the corners of faces keep their
/// order. Vertices on the *cut*, where faces of the mesh are left out, are tagged as corners: they
/// stay as they are.
struct MeshRegion {
    mesh::Topology mesh;
    multires::MeshTags tags;
    std::vector<mesh::Index> vertices;    ///< [vertex]: its number in the whole mesh
    std::vector<mesh::Index> half_edges;  ///< [half-edge]
    std::vector<int> rings;               ///< [vertex]: how many edges it is away from the seeds
    std::vector<bool> on_cut;             ///< [edge]
    bool has_cut = false;
};

/// The faces within `rings` rings around some vertices, and a few more so that they are a manifold;
/// for an even sqrt(3) step, also so that no face has two boundary edges. Complexity: O(mesh), and
/// each ring in the order of the search.
[[nodiscard]] MeshRegion region_around(const mesh::Topology& mesh, const multires::MeshTags& tags,
                                       const VertexFaces& around,
                                       std::span<const mesh::Index> seeds, int rings,
                                       mesh::Split split);

}  // namespace relief::edit
