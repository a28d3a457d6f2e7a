#pragma once

#include <string>
#include <vector>

#include "relief/core/polygon_mesh.h"

/// Meshes with subdivision connectivity on which codecs are compared.
namespace relief::peers {

struct NamedMesh {
    std::string name;
    PolygonMesh mesh;
};

/// An icosahedron divided `steps` times into four, its vertices on a star-shaped surface of waves
/// of six lengths, and moved by as much noise along the radius.
[[nodiscard]] PolygonMesh wavy_sphere(int steps, double noise);

/// Subdivision surfaces of all three schemes over bases of 12 and 8 vertices.
[[nodiscard]] std::vector<NamedMesh> exact_surfaces();

}  // namespace relief::peers
