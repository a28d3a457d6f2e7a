#pragma once

#include "relief/mesh/triangulation.h"

namespace relief::mesh {

/// Whether the barycentric coordinates of p, which is relative to the mesh's origin, are at least
/// -1e-12. Both triangles of an edge look at the same number, so no point falls between them.
inline bool contains(const PlaneTriangles& mesh, Index t, Vec2 p) {
    constexpr double kOutside = -1e-12;
    const auto& v = mesh.triangles[t];
    const TriangleCorners c = mesh.corners(t);
    const double least = kOutside * orient(c[0], c[1], c[2]);
    const auto side = [&](int i, int j) {
        return v[i] < v[j] ? orient(c[i], c[j], p) : -orient(c[j], c[i], p);
    };
    return side(0, 1) >= least && side(1, 2) >= least && side(2, 0) >= least;
}

}  // namespace relief::mesh
