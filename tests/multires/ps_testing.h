#pragma once

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mesh/triangle_meshes.h"
#include "relief/multires/ps_refine.h"

/// Meshes, splines and pointwise evaluation for the tests of Powell-Sabin splines.
namespace relief::multires::ps::test {

using mesh::Index;
using mesh::Triangulation;
using relief::test::Noise;

inline Vec2 point_of(const nlohmann::json& p) {
    return {p[0], p[1]};
}

template <class T>
T must(Result<T> result) {
    if (!result.ok()) throw std::runtime_error(result.error().text());
    return *std::move(result);
}

inline nlohmann::json golden_cases() {
    return relief::test::reference("powell_sabin.json")["cases"];
}

inline Triangulation golden_mesh(const nlohmann::json& mesh) {
    std::vector<Vec2> vertices;
    std::vector<std::array<Index, 3>> triangles;
    for (const auto& v : mesh["V"]) vertices.push_back(point_of(v));
    for (const auto& t : mesh["T"]) triangles.push_back({t[0], t[1], t[2]});
    return must(mesh::build(vertices, triangles));
}

inline Coefficients golden_coefficients(const nlohmann::json& c) {
    Coefficients spline;
    for (const auto& row : c) spline.push_back({row[0], row[1], row[2]});
    return spline;
}

/// The space of a golden case with its own control triangles.
inline Space golden_space(const nlohmann::json& item) {
    Space space = must(make_space(golden_mesh(item["mesh"])));
    for (Index v = 0; v < space.mesh.vertex_count(); ++v)
        for (int j = 0; j < 3; ++j)
            space.control[v][j] =
                point_of(item["Q"][v][j]) - space.mesh.origin - space.mesh.vertex(v);
    return space;
}

inline Coefficients random_spline(const Space& space, std::uint64_t seed) {
    Noise noise(seed);
    Coefficients spline(space.mesh.vertex_count());
    for (Heights& heights : spline)
        for (double& height : heights) height = noise();
    return spline;
}

/// Jets at points of given triangles, straight from the element.
class Pointwise {
  public:
    Pointwise(const Space& space, const Coefficients& spline)
        : space_(space), planes_(tangent_planes(space, spline)) {}

    [[nodiscard]] spline::PsPolynomials polynomials(Index t) const {
        const auto& v = space_.mesh.triangles[t];
        return space_.element(t).polynomials(
            std::array{planes_[v[0]], planes_[v[1]], planes_[v[2]]});
    }
    /// The point is relative to the mesh's origin.
    [[nodiscard]] spline::PlaneJet jet(Index t, Vec2 point) const {
        const spline::PsElement element = space_.element(t);
        const Vec2 offset = point - element.centre();
        return polynomials(t).jet(element.piece_of(offset), offset);
    }

  private:
    const Space& space_;
    TangentPlanes planes_;
};

/// The triangle in which a point, relative to the origin, lies deepest.
inline Index brute_force_locate(const Triangulation& mesh, Vec2 point) {
    Index best = 0;
    double deepest = -INFINITY;
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const auto w = spline::barycentric(mesh.corners(t), point);
        const double depth = std::min({w[0], w[1], w[2]});
        if (depth > deepest) {
            deepest = depth;
            best = t;
        }
    }
    return best;
}

/// A point of a triangle, not too close to its border.
inline Vec2 inner_point(const Triangulation& mesh, Index t, Noise& noise) {
    const TriangleCorners v = mesh.corners(t);
    const double a = 0.31 + 0.3 * noise();
    const double b = (1 - a) * (0.5 + 0.45 * noise());
    return a * v[0] + (b * v[1] + (1 - a - b) * v[2]);
}

/// Spaces of all kinds of triangulations.
inline std::vector<Space> space_family() {
    std::vector<Space> family;
    for (Triangulation& mesh : relief::test::triangulation_family())
        family.push_back(must(make_space(std::move(mesh))));
    return family;
}

}  // namespace relief::multires::ps::test
