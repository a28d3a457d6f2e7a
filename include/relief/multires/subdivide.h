#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "relief/multires/mesh_hierarchy.h"

/// Forward subdivision of meshes with creases of any sharpness, and limits. Source:
/// reverse-subdivision.md sections 2 to 5; creases: DeRose, Kass, Truong, "Subdivision surfaces in
/// character animation", section 3.
namespace relief::multires {

/// How many steps edges and vertices stay sharp: HUGE_VAL for ever, a fraction blends with the
/// smooth rule. Boundary edges are sharp for ever anyway.
struct Sharpness {
    std::vector<double> edges;     ///< [edge]; empty: none
    std::vector<double> vertices;  ///< [vertex]; empty: none

    friend bool operator==(const Sharpness&, const Sharpness&) = default;
};

/// Those that are sharp for ever.
[[nodiscard]] MeshTags tags_of(const Sharpness& sharpness);

template <class T>
struct SubdividedMesh {
    mesh::Topology mesh;
    /// Arrays over the vertices: places, and what is to follow them in the same way.
    std::vector<std::vector<Vec3<T>>> arrays;
    Sharpness sharpness;  ///< what is left of it
};

/// `steps` subdivisions, none for 0. Arrays have one element a vertex. Errors: those of
/// Subdivider::prepare; InvalidArgument for arrays of another size. T: float or double. Complexity:
/// O(result). Where only faces and points are wanted, or both again and again: Subdivider.
template <class T>
[[nodiscard]] Result<SubdividedMesh<T>> subdivide(SubdividedMesh<T> mesh, const MeshSpec& spec,
                                                  int steps);

/// Where the vertices of a mesh go when it is subdivided for ever. For Catmull-Clark vertices with
/// other faces than quads this needs one step first. Sharpness that is left counts as none, unless
/// it is for ever. Requires: as subdivide. Complexity: O(n).
template <class T>
[[nodiscard]] Result<std::vector<Vec3<T>>> limit_points(const mesh::Topology& mesh,
                                                        std::span<const Vec3<T>> points,
                                                        const Sharpness& sharpness,
                                                        MeshScheme scheme);

/// Unit normals there: exact at smooth vertices; at creases, corners and boundaries the mean of
/// those of the faces between limit points. Zero where the surface has none.
template <class T>
[[nodiscard]] Result<std::vector<Vec3<T>>> limit_normals(const mesh::Topology& mesh,
                                                         std::span<const Vec3<T>> points,
                                                         const Sharpness& sharpness,
                                                         MeshScheme scheme);

}  // namespace relief::multires
