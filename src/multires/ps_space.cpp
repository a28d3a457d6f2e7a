#include "relief/multires/ps_space.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "multires/ps_control.h"
#include "multires/ps_errors.h"

namespace relief::multires::ps {

using mesh::Index;
using mesh::Triangulation;
using spline::PsBasis;
using spline::TangentPlane;

namespace {

constexpr double kLargest = 1e150;

bool usable(const Heights& heights) {
    return std::abs(heights[0]) <= kLargest && std::abs(heights[1]) <= kLargest &&
           std::abs(heights[2]) <= kLargest;
}
bool usable(const TangentPlane& plane) {
    return usable(Heights{plane.value, plane.gradient.x, plane.gradient.y});
}

template <class T>
Status check_elements(const mesh::PlaneTriangles& mesh, std::span<const T> spline) {
    if (spline.size() != mesh.vertex_count())
        return bad_input("size_mismatch: a spline of this space has coefficients for " +
                         std::to_string(mesh.vertex_count()) + " vertices, not for " +
                         std::to_string(spline.size()));
    const std::size_t bad =
        first_failure(spline.size(), [&](Index v) { return usable(spline[v]); });
    if (bad == spline.size()) return {};
    return bad_input(
        "non_finite_input: a coefficient is not finite or beyond 1e150; leave the vertex out or "
        "give it a value",
        "vertex " + std::to_string(bad));
}

}  // namespace

std::array<TangentPlane, 3> basis_planes(const TriangleCorners& q) {
    const double area = orient(q[0], q[1], q[2]);
    const std::array<double, 3> value = spline::barycentric(q, {});
    std::array<TangentPlane, 3> planes;
    for (int j = 0; j < 3; ++j) {
        const Vec2 opposite = q[(j + 2) % 3] - q[(j + 1) % 3];
        planes[j] = {value[j], {-opposite.y / area, opposite.x / area}};
    }
    return planes;
}

TangentPlane tangent_plane(const TriangleCorners& control, const Heights& heights) {
    const std::array<TangentPlane, 3> basis = basis_planes(control);
    // Differences, so that a constant has no gradient at all.
    const double rise1 = heights[1] - heights[0];
    const double rise2 = heights[2] - heights[0];
    return {heights[0] + rise1 * basis[1].value + rise2 * basis[2].value,
            rise1 * basis[1].gradient + rise2 * basis[2].gradient};
}

Heights heights(const TriangleCorners& control, const TangentPlane& plane) {
    return {plane.at(control[0]), plane.at(control[1]), plane.at(control[2])};
}

TangentPlanes tangent_planes(const Space& space, std::span<const Heights> spline) {
    TangentPlanes planes(spline.size());
    for_each_index(spline.size(),
                   [&](Index v) { planes[v] = tangent_plane(space.control[v], spline[v]); });
    return planes;
}

Coefficients coefficients(const Space& space, std::span<const TangentPlane> planes) {
    Coefficients spline(planes.size());
    for_each_index(planes.size(),
                   [&](Index v) { spline[v] = heights(space.control[v], planes[v]); });
    return spline;
}

PsBasis Space::basis(Index t) const {
    PsBasis basis;
    for (int k = 0; k < 3; ++k) {
        const auto planes = basis_planes(control[mesh.triangles[t][k]]);
        std::copy(planes.begin(), planes.end(), basis.begin() + 3 * k);
    }
    return basis;
}

Result<std::vector<TriangleCorners>> smallest_controls(const Triangulation& mesh,
                                                       const Split& split) {
    const mesh::VertexStars stars = mesh::vertex_triangles(mesh);
    std::vector<TriangleCorners> control(mesh.vertex_count());
    const std::size_t bad = first_failure(control.size(), [&](Index v) {
        std::vector<Vec2> points = {{}};
        for (const Index t : stars.of(v)) {
            const auto& corners = mesh.triangles[t];
            const auto k =
                static_cast<Index>(std::find(corners.begin(), corners.end(), v) - corners.begin());
            const auto halfway = halfway_points(mesh, split, t, k);
            points.insert(points.end(), halfway.begin(), halfway.end());
        }
        const auto triangle = spline::smallest_triangle(points);
        if (triangle) control[v] = *triangle;
        return triangle.has_value();
    });
    if (bad == control.size()) return control;
    return bad_input("degenerate_hull: the triangles at the vertex are too thin; remove them",
                     "vertex " + std::to_string(bad));
}

Result<Space> make_space(Triangulation mesh, const SplitOptions& options) {
    RELIEF_TRY(Split cut, split(mesh, options));
    RELIEF_TRY(std::vector<TriangleCorners> control, smallest_controls(mesh, cut));
    return Space{std::move(mesh), std::move(cut), std::move(control)};
}

Status check(const mesh::PlaneTriangles& mesh, std::span<const Heights> spline) {
    return check_elements(mesh, spline);
}
Status check(const mesh::PlaneTriangles& mesh, std::span<const TangentPlane> planes) {
    return check_elements(mesh, planes);
}

double enclosure_excess(const Space& space) {
    double excess = 0;
    const auto include = [&](Index v, Vec2 point) {
        for (const double weight : spline::barycentric(space.control[v], point))
            excess = std::max(excess, -weight);
    };
    for (Index t = 0; t < space.mesh.triangle_count(); ++t)
        for (Index k = 0; k < 3; ++k) {
            const Index v = space.mesh.triangles[t][k];
            include(v, {});
            for (const Vec2 p : halfway_points(space.mesh, space.split, t, k)) include(v, p);
        }
    return excess;
}

}  // namespace relief::multires::ps
