#include "mesh/triangulation_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "mesh/plane_checks.h"

namespace relief::mesh {

namespace {

/// Twice the area of a triangle must be more than this times its squared longest side.
constexpr double kThinnest = 1e-12;
constexpr double kSmallAngle = 1;       ///< degrees
constexpr double kAngleOverlap = 1e-6;  ///< radians that fans at a boundary vertex may share

/// A triangle seen from one of its vertices: it covers the directions from `right` to `left`.
struct Wedge {
    Vec2 right;
    Vec2 left;
};

Wedge wedge_at(const Triangulation& mesh, Index t, Index v) {
    const auto& corner = mesh.triangles[t];
    const Index k = corner[0] == v ? 0 : corner[1] == v ? 1 : 2;
    const Vec2 tip = mesh.vertex(v);
    return {mesh.vertex(corner[(k + 1) % 3]) - tip, mesh.vertex(corner[(k + 2) % 3]) - tip};
}

/// Whether a direction lies in a wedge, and not just at its left side.
bool covers(const Wedge& wedge, Vec2 direction) {
    const double margin = kAngleOverlap * length(direction) * length(wedge.left);
    return cross(wedge.right, direction) >= 0 && cross(direction, wedge.left) > margin;
}

/// Whether any fan of triangles at a vertex begins within another one, or has come round to itself.
bool fans_overlap(const Triangulation& mesh, Index v, std::span<const Index> star) {
    for (const Index t : star) {
        const auto& corner = mesh.triangles[t];
        const Index k = corner[0] == v ? 0 : corner[1] == v ? 1 : 2;
        if (mesh.neighbour(t, k) != kNone) continue;
        const Vec2 begin = wedge_at(mesh, t, v).right;
        for (const Index other : star)
            if (other != t && covers(wedge_at(mesh, other, v), begin)) return true;
    }
    return false;
}

Index opposite_corner(const Triangulation& mesh, Index t, Index e) {
    const auto& edge = mesh.triangle_edges[t];
    return mesh.triangles[t][edge[0] == e ? 2 : edge[1] == e ? 0 : 1];
}

}  // namespace

std::optional<Index> find_thin_triangle(const Triangulation& mesh) {
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
        if (!(std::abs(orient(a, b, c)) > kThinnest * longest)) return t;
    }
    return std::nullopt;
}

Status check_thickness(const Triangulation& mesh) {
    const auto thin = find_thin_triangle(mesh);
    if (!thin) return {};
    return bad_mesh(
        "degenerate_triangle: its corners lie on a line or two of them at one place; remove it or "
        "move them",
        "triangle", *thin);
}

/// The triangles round an interior vertex wind round it as often as they cross the ray from it in
/// direction +x. That is counted exactly, while angles would have to be summed.
Status check_folds(const Triangulation& mesh) {
    std::vector<Index> crossings(mesh.vertex_count());
    std::vector<std::uint8_t> on_boundary(mesh.vertex_count());
    for (const auto& v : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const double level = mesh.y[v[k]];
            crossings[v[k]] += mesh.y[v[(k + 1) % 3]] <= level && mesh.y[v[(k + 2) % 3]] > level;
        }
    for (Index e = 0; e < mesh.edge_count(); ++e)
        if (mesh.on_boundary(e)) on_boundary[mesh.edges[e][0]] = on_boundary[mesh.edges[e][1]] = 1;
    const VertexStars stars = vertex_triangles(mesh);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const bool folded = on_boundary[v] ? fans_overlap(mesh, v, stars.of(v)) : crossings[v] != 1;
        if (folded)
            return bad_mesh(
                "folded_mesh: its triangles cover a direction twice; a surface over the plane "
                "needs disjoint triangles",
                "vertex", v);
    }
    return {};
}

Status check_hanging_vertices(const Triangulation& mesh) {
    std::vector<BoundaryEdge> boundary;
    std::vector<Index> vertices;
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        if (!mesh.on_boundary(e)) continue;
        const auto [low, high] = mesh.edges[e];
        const auto [left, right] = mesh.edge_triangles[e];
        const Index t = left == kNone ? right : left;
        // A corner near the side of its own triangle makes it thin, which has its own threshold.
        boundary.push_back({low, high, t, opposite_corner(mesh, t, e)});
        vertices.insert(vertices.end(), mesh.edges[e].begin(), mesh.edges[e].end());
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    const auto hanging = find_hanging_vertex(mesh.x, mesh.y, vertices, boundary);
    if (!hanging) return {};
    return bad_mesh("hanging_vertex: it lies inside the edge from vertex " +
                        std::to_string(hanging->edge.from) + " to vertex " +
                        std::to_string(hanging->edge.to) + " of triangle " +
                        std::to_string(hanging->edge.face) + "; split that triangle there",
                    "vertex", hanging->vertex);
}

Status check_overlap(const Triangulation& mesh) {
    const auto pair = find_overlap(mesh.triangle_count(), [&](Index t) { return mesh.corners(t); });
    if (!pair) return {};
    return bad_mesh("overlap: its interior meets that of triangle " + std::to_string((*pair)[1]) +
                        "; a surface over the plane needs disjoint triangles",
                    "triangle", (*pair)[0]);
}

double smallest_angle(const TriangleCorners& v) {
    double smallest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
        const Vec2 a = v[(k + 1) % 3] - v[k];
        const Vec2 b = v[(k + 2) % 3] - v[k];
        smallest = std::min(smallest, std::atan2(std::abs(cross(a, b)), dot(a, b)));
    }
    return smallest * 180 / 3.14159265358979323846;
}

std::vector<SmallAngle> small_angles(const Triangulation& mesh) {
    std::vector<SmallAngle> found;
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const double degrees = smallest_angle(mesh.corners(t));
        if (degrees >= kSmallAngle) continue;
        found.push_back({t, degrees,
                         "small_angle: triangle " + std::to_string(t) + " has an angle of " +
                             std::to_string(degrees) +
                             " degrees; refined splines lose digits there"});
    }
    return found;
}

}  // namespace relief::mesh
