#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "relief/mesh/triangulation.h"
#include "support.h"

/// Triangulations for the tests of all modules.
namespace relief::test {

using mesh::Index;

struct TriangleMesh {
    std::vector<Vec2> vertices;
    std::vector<std::array<Index, 3>> triangles;
};

/// cols x rows squares with the lower left corner at `low`, cut along diagonals in turn; interior
/// vertices are moved by up to `shake` in each direction. Valid for shake < 0.2.
inline TriangleMesh triangle_grid(Index cols, Index rows, double shake = 0, Vec2 low = {},
                                  std::uint64_t seed = 1) {
    TriangleMesh mesh;
    Noise noise(seed);
    for (Index r = 0; r <= rows; ++r)
        for (Index c = 0; c <= cols; ++c) {
            const bool inside = r > 0 && r < rows && c > 0 && c < cols;
            const double dx = inside ? shake * noise() : 0;
            const double dy = inside ? shake * noise() : 0;
            mesh.vertices.push_back({low.x + c + dx, low.y + r + dy});
        }
    for (Index r = 0; r < rows; ++r)
        for (Index c = 0; c < cols; ++c) {
            const Index a = r * (cols + 1) + c;
            const Index b = a + cols + 1;
            if ((r + c) % 2 == 0)
                mesh.triangles.insert(mesh.triangles.end(), {{a, a + 1, b + 1}, {a, b + 1, b}});
            else
                mesh.triangles.insert(mesh.triangles.end(), {{a, a + 1, b}, {a + 1, b + 1, b}});
        }
    return mesh;
}

/// Triangles round an interior vertex.
inline TriangleMesh triangle_star(Index valence) {
    TriangleMesh mesh{{{0.1, -0.05}}, {}};
    for (Index k = 0; k < valence; ++k) {
        const double angle = 2 * 3.14159265358979323846 * (k + 0.2 * (k % 2)) / valence;
        const double radius = 1 + 0.3 * (k % 3);
        mesh.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    for (Index k = 0; k < valence; ++k) mesh.triangles.push_back({0, 1 + k, 1 + (k + 1) % valence});
    return mesh;
}

inline TriangleMesh without_triangle(TriangleMesh mesh, std::size_t triangle) {
    mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(triangle));
    return mesh;
}

inline mesh::Triangulation built(const TriangleMesh& mesh) {
    auto result = mesh::build(mesh.vertices, mesh.triangles, {.check_overlap = true});
    if (!result.ok()) throw std::runtime_error(result.error().text());
    return *std::move(result);
}

/// Two fans that meet in vertex 2 only.
inline TriangleMesh bow_tie() {
    return {{{0, 0}, {2, -1}, {1, 0.5}, {0, 1}, {3, 0}, {2, 2}}, {{0, 2, 3}, {0, 1, 2}, {2, 4, 5}}};
}

/// Regular, distorted, with a hole, far from the origin, many valences, a bow-tie, two components,
/// clockwise triangles.
inline std::vector<mesh::Triangulation> triangulation_family() {
    TriangleMesh clockwise = triangle_grid(2, 3, 0.15);
    for (std::size_t t = 0; t < clockwise.triangles.size(); t += 2)
        std::swap(clockwise.triangles[t][0], clockwise.triangles[t][2]);
    TriangleMesh two = triangle_grid(2, 2, 0.1);
    for (const Vec2 v : triangle_star(5).vertices) two.vertices.push_back({v.x + 7, v.y});
    for (const auto& [a, b, c] : triangle_star(5).triangles)
        two.triangles.push_back({a + 9, b + 9, c + 9});
    std::vector<mesh::Triangulation> family;
    for (const TriangleMesh& mesh :
         {TriangleMesh{{{0, 0}, {3, 1}, {1, 2}}, {{0, 1, 2}}}, triangle_grid(1, 1),
          triangle_grid(3, 2), triangle_grid(6, 5, 0.19),
          without_triangle(triangle_grid(4, 4, 0.15), 13), triangle_grid(3, 3, 0.1, {2e6, -1e6}),
          triangle_star(3), triangle_star(4), triangle_star(13), bow_tie(), clockwise, two})
        family.push_back(built(mesh));
    return family;
}

}  // namespace relief::test
