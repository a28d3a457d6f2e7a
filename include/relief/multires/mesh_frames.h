#pragma once

#include <span>
#include <vector>

#include "relief/core/vec3.h"
#include "relief/mesh/topology.h"

/// Frames along a surface, in which details keep their meaning when the surface is bent. Source:
/// reverse-subdivision.md section 11.
namespace relief::multires {

/// An orthonormal frame, and the size of the surface around it.
struct MeshFrame {
    Vec3<double> tangent{1, 0, 0};    ///< towards the neighbour with the smallest number
    Vec3<double> bitangent{0, 1, 0};  ///< normal x tangent
    Vec3<double> normal{0, 0, 1};
    double size = 0;  ///< root of the area of the faces around; 0: degenerate, the frame is that of
                      ///< the coordinates

    /// x tangent + y bitangent + z normal.
    [[nodiscard]] Vec3<double> out(const Vec3<double>& local) const {
        return local.x * tangent + local.y * bitangent + local.z * normal;
    }
    [[nodiscard]] Vec3<double> in(const Vec3<double>& global) const {
        return {dot(tangent, global), dot(bitangent, global), dot(normal, global)};
    }
};

/// Frames of vertices `first` .. of a mesh with its points. Complexity: O(n).
[[nodiscard]] std::vector<MeshFrame> frames(const mesh::Topology& mesh, const Vec3<double>* points,
                                            mesh::Index first);

/// Those of some vertices, ascending.
[[nodiscard]] std::vector<MeshFrame> frames(const mesh::Topology& mesh, const Vec3<double>* points,
                                            std::span<const mesh::Index> vertices);

}  // namespace relief::multires
