#pragma once

#include <span>
#include <vector>

#include "relief/core/vec3.h"
#include "relief/mesh/topology.h"

namespace relief::edit {

/// The faces around each vertex of a mesh. Needs of the mesh its faces alone.
class VertexFaces {
  public:
    /// Complexity: O(n).
    explicit VertexFaces(const mesh::Topology& mesh);

    /// Ascending.
    [[nodiscard]] std::span<const mesh::Index> of(mesh::Index v) const {
        return {faces_.data() + first_[v], first_[v + 1] - first_[v]};
    }
    /// Adds the vertices at the other ends of the edges at v, each once.
    void neighbours(const mesh::Topology& mesh, mesh::Index v, std::vector<mesh::Index>& out) const;

  private:
    Buffer<mesh::Index> first_;  ///< [vertex], and their number
    Buffer<mesh::Index> faces_;
};

/// Pairs of vertices, one for each edge. Complexity: O(n).
[[nodiscard]] std::vector<std::array<mesh::Index, 2>> edges_of(const mesh::Topology& mesh,
                                                               const VertexFaces& around);

/// The sum of the cross products of the faces at v: along the normal, weighted by areas.
[[nodiscard]] Vec3<double> normal_at(const mesh::Topology& mesh, const VertexFaces& around,
                                     const Vec3<double>* points, mesh::Index v);

/// Mean curvature from the angles across the edges (Meyer, Desbrun, Schroeder, Barr: Discrete
/// differential-geometry operators for triangulated 2-manifolds, 2002) with a third of the area
/// around; polygons as fans. Positive where the surface is a valley seen from its normal's side; 0
/// on boundaries. normal: of length 1.
[[nodiscard]] double mean_curvature(const mesh::Topology& mesh, const VertexFaces& around,
                                    const Vec3<double>* points, mesh::Index v,
                                    const Vec3<double>& normal);

}  // namespace relief::edit
