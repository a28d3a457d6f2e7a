#pragma once

#include <optional>

#include "codec/mesh_extras.h"
#include "codec/mesh_synthesis.h"
#include "relief/codec/mesh_codec.h"
#include "relief/mesh/closest.h"

/// How far decoded meshes are off.
namespace relief::codec {

struct MeshErrors {
    double max = 0;
    double rms = 0;
    double square = 0;  ///< of the vertices, summed
};

/// How many points of each surface are measured: to know, and to search.
inline constexpr std::int64_t kAllSamples = 60000;
inline constexpr std::int64_t kSomeSamples = 6000;

/// Coordinates that mesh::surface_distance can measure.
inline constexpr double kLargestMeasured = 1e75;

/// Compares meshes with one that is given. It must outlive this, and so must its points, which are
/// in the numbers of a hierarchy.
class MeshMeasure {
  public:
    /// original: what distances by surface are measured from; null: the mesh.
    MeshMeasure(const PolygonMesh& mesh, const MeshPoints& points, const MeshOrder& order,
                MeshDistance distance, const PolygonMesh* original);

    /// samples: on each surface.
    [[nodiscard]] MeshErrors operator()(const MeshPoints& decoded, std::int64_t samples) const;

  private:
    const MeshPoints& points_;
    const MeshOrder& order_;
    MeshDistance distance_;
    PolygonMesh shape_;  ///< the mesh without what is not its shape
    const PolygonMesh* original_;
    std::optional<mesh::TriangleTree> tree_;  ///< of what distances by surface are measured from
};

}  // namespace relief::codec
