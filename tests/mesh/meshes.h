#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "relief/mesh/quadrangulation.h"
#include "support.h"

/// Quadrangulations for the tests of all modules.
namespace relief::test {

struct QuadMesh {
    std::vector<Vec2> vertices;
    std::vector<std::array<mesh::Index, 4>> quads;
};

/// cols x rows squares of side `cell` with the lower left corner at `low`; interior vertices are
/// moved by up to `shake` cells in each direction. Convex for shake < 0.2.
inline QuadMesh grid_mesh(mesh::Index cols, mesh::Index rows, double cell = 1, double shake = 0,
                          Vec2 low = {}, std::uint64_t seed = 1) {
    QuadMesh mesh;
    Noise noise(seed);
    for (mesh::Index r = 0; r <= rows; ++r)
        for (mesh::Index c = 0; c <= cols; ++c) {
            const bool inside = r > 0 && r < rows && c > 0 && c < cols;
            const double dx = inside ? shake * noise() : 0;
            const double dy = inside ? shake * noise() : 0;
            mesh.vertices.push_back({low.x + cell * (c + dx), low.y + cell * (r + dy)});
        }
    for (mesh::Index r = 0; r < rows; ++r)
        for (mesh::Index c = 0; c < cols; ++c) {
            const mesh::Index v = r * (cols + 1) + c;
            mesh.quads.push_back({v, v + 1, v + cols + 2, v + cols + 1});
        }
    return mesh;
}

inline QuadMesh without_quad(QuadMesh mesh, std::size_t quad) {
    mesh.quads.erase(mesh.quads.begin() + static_cast<std::ptrdiff_t>(quad));
    return mesh;
}

/// `valence` quads round an interior vertex, irregular.
inline QuadMesh star_mesh(mesh::Index valence) {
    QuadMesh mesh;
    mesh.vertices.push_back({0.1, -0.05});
    for (mesh::Index k = 0; k < 2 * valence; ++k) {
        const double angle = 3.14159265358979323846 * (k + 0.15 * (k % 3)) / valence;
        const double radius = k % 2 == 0 ? 1.0 : 1.3 / std::cos(1.6 / valence);
        mesh.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    for (mesh::Index k = 0; k < valence; ++k)
        mesh.quads.push_back({0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % (2 * valence)});
    return mesh;
}

/// A convex quad with corners near those of the unit square.
inline QuadMesh random_quad(std::uint64_t seed) {
    Noise noise(seed);
    const auto corner = [&](double x, double y) {
        return Vec2{x + 0.24 * noise(), y + 0.24 * noise()};
    };
    return {{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)}, {{0, 1, 2, 3}}};
}

inline mesh::Quadrangulation built(const QuadMesh& mesh) {
    auto result = mesh::build(mesh.vertices, mesh.quads, {.check_overlap = true});
    EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().text());
    return *std::move(result);
}

/// Regular, distorted, with a hole, far from the origin, valences 3, 5 and 6, quads that touch in
/// one vertex.
inline std::vector<mesh::Quadrangulation> mesh_family() {
    QuadMesh corner = grid_mesh(2, 2);
    corner.quads = {corner.quads[0], corner.quads[3]};
    corner.vertices = {{0, 0}, {1, 0}, {2, 1}, {0, 1}, {1, 1}, {2, 2}, {1, 2}};
    corner.quads = {{0, 1, 4, 3}, {4, 2, 5, 6}};
    std::vector<mesh::Quadrangulation> family;
    for (const QuadMesh& mesh :
         {grid_mesh(1, 1), grid_mesh(3, 2, 0.5), grid_mesh(4, 4, 1, 0.19),
          without_quad(grid_mesh(3, 3, 1, 0.15), 4), grid_mesh(2, 2, 1, 0.1, {2e6, -1e6}),
          star_mesh(3), star_mesh(5), star_mesh(6), corner, random_quad(5)})
        family.push_back(built(mesh));
    return family;
}

}  // namespace relief::test
