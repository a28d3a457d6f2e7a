#pragma once

#include <stdexcept>

#include "relief/remesh/surface.h"
#include "shapes.h"

/// Surfaces for the tests of the remesher.
namespace relief::test {

inline PolygonMesh polygons_of(const Shape& shape) {
    PolygonMesh mesh{.vertices = shape.points, .offsets = shape.faces.offsets};
    mesh.corners.assign(shape.faces.corners.begin(), shape.faces.corners.end());
    return mesh;
}

inline remesh::Surface surface_of(const Shape& shape, const remesh::SurfaceOptions& options = {}) {
    auto surface = remesh::surface_of(polygons_of(shape), options);
    if (!surface.ok()) throw std::runtime_error(surface.error().text());
    return *std::move(surface);
}

/// A tube of radius 1 around the z axis, open at both ends, whose sections are polygons of `sides`.
inline Shape tube(mesh::Index sides, mesh::Index rings, double height) {
    Shape shape;
    for (mesh::Index r = 0; r <= rings; ++r)
        for (mesh::Index k = 0; k < sides; ++k)
            shape.points.push_back({std::cos(2 * M_PI * k / sides), std::sin(2 * M_PI * k / sides),
                                    height * r / rings});
    for (mesh::Index r = 0; r < rings; ++r)
        for (mesh::Index k = 0; k < sides; ++k) {
            const mesh::Index a = r * sides + k;
            const mesh::Index b = r * sides + (k + 1) % sides;
            shape.add({a, b, b + sides});
            shape.add({a, b + sides, a + sides});
        }
    return shape;
}

/// Irregular samples of a sphere with bumps: points of a spiral, joined as their hull is; made by
/// splitting an octahedron and moving the points about.
inline Shape bumpy_sphere(int splits, double bumps) {
    Shape shape = octahedron();
    for (int k = 0; k < splits; ++k) {
        Shape finer{{}, shape.points};
        std::map<std::pair<mesh::Index, mesh::Index>, mesh::Index> middles;
        const auto middle = [&](mesh::Index a, mesh::Index b) {
            const auto [found, is_new] = middles.emplace(std::minmax(a, b), finer.size());
            if (is_new) {
                Point p{};
                for (std::size_t i = 0; i < 3; ++i)
                    p[i] = (0.5 + 0.07 * std::sin(7.0 * a + 11.0 * b)) * finer.points[a][i] +
                           (0.5 - 0.07 * std::sin(7.0 * a + 11.0 * b)) * finer.points[b][i];
                finer.points.push_back(p);
            }
            return found->second;
        };
        for (std::size_t f = 0; f < shape.faces.size(); ++f) {
            const auto c = shape.faces[f];
            const mesh::Index e0 = middle(c[0], c[1]);
            const mesh::Index e1 = middle(c[1], c[2]);
            const mesh::Index e2 = middle(c[2], c[0]);
            finer.add({c[0], e0, e2});
            finer.add({c[1], e1, e0});
            finer.add({c[2], e2, e1});
            finer.add({e0, e1, e2});
        }
        shape = std::move(finer);
    }
    for (Point& p : shape.points) {
        const double size = std::hypot(p[0], p[1], p[2]);
        const double radius =
            (1 + bumps * std::sin(3 * p[0] / size) * std::cos(4 * p[1] / size + p[2] / size)) /
            size;
        for (double& x : p) x *= radius;
    }
    return shape;
}

}  // namespace relief::test
