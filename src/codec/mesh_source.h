#pragma once

#include "codec/mesh_extras.h"
#include "codec/mesh_synthesis.h"

/// A mesh on its way into a file.
namespace relief::codec {

/// The mesh in the numbers of its hierarchy.
struct MeshSource {
    MeshHeader header;  ///< what is known before quantising
    mesh::Topology base;
    multires::MeshTags tags;  ///< of the base, as they are stored
    MeshSynthesis synthesis;
    MeshPoints points;  ///< of the finest level
    MeshOrder order;
    mesh::Index sides = 3;
    std::int64_t lost_creases = 0;

    [[nodiscard]] const multires::MeshHierarchy& hierarchy() const { return synthesis.hierarchy(); }
};

/// Coefficients, details in the frame of the coordinates.
struct MeshCoefficients {
    MeshPoints points;  ///< the base's, followed by details
    multires::StiffResiduals residuals;
};

/// Errors: those of encode_mesh.
[[nodiscard]] Result<MeshSource> prepare_mesh(const PolygonMesh& mesh, multires::MeshScheme scheme,
                                              const MeshEncodeOptions& options);
[[nodiscard]] MeshCoefficients coefficients_of(const MeshSynthesis& synthesis,
                                               const MeshPoints& points);

/// The mesh with the numbers of its hierarchy.
[[nodiscard]] PolygonMesh reordered(const PolygonMesh& mesh, const MeshOrder& order,
                                    mesh::Index sides);

/// Faces of a polygon mesh, for mesh::build.
[[nodiscard]] std::vector<mesh::Index> corners_of(const PolygonMesh& mesh);

}  // namespace relief::codec
