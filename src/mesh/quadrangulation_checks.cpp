#include "mesh/quadrangulation_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mesh/plane_checks.h"

namespace relief::mesh {

namespace {

constexpr double kConvexity = 1e-10;
constexpr double kSmallAngle = 1;  ///< degrees

double longest_side(const QuadCorners& v) {
    double longest = 0;
    for (int i = 0; i < 4; ++i) longest = std::max(longest, length(v[(i + 1) % 4] - v[i]));
    return longest;
}

}  // namespace

Status check_convex(const Quadrangulation& mesh) {
    for (Index q = 0; q < mesh.quad_count(); ++q) {
        const QuadCorners v = mesh.corners(q);
        const double size = longest_side(v);
        for (int i = 0; i < 4; ++i) {
            const double corner = cross(v[i] - v[(i + 3) % 4], v[(i + 1) % 4] - v[i]);
            if (corner > kConvexity * size * size) continue;
            return bad_mesh("not_strictly_convex: the corner at vertex " +
                                std::to_string(mesh.quads[q][i]) +
                                " has 180 degrees or more; split the quad or move the vertex",
                            "quad", q);
        }
    }
    return {};
}

Status check_vertices_used(const Quadrangulation& mesh) {
    std::vector<std::uint8_t> used(mesh.vertex_count());
    for (const auto& quad : mesh.quads)
        for (const Index v : quad) used[v] = 1;
    const auto unused = std::find(used.begin(), used.end(), 0);
    if (unused == used.end()) return {};
    return bad_mesh("unused_vertex: it belongs to no quad; remove it", "vertex",
                    static_cast<std::size_t>(unused - used.begin()));
}

Status check_t_junctions(const Quadrangulation& mesh) {
    std::vector<Index> vertices(mesh.vertex_count());
    std::iota(vertices.begin(), vertices.end(), Index{0});
    std::vector<BoundaryEdge> boundary;
    const auto sides = edge_quads(mesh);
    for (Index e = 0; e < mesh.edge_count(); ++e)
        if (sides[e][1] == kNoQuad)
            boundary.push_back({mesh.edges[e][0], mesh.edges[e][1], sides[e][0]});
    const auto hanging = find_hanging_vertex(mesh.x, mesh.y, vertices, boundary);
    if (!hanging) return {};
    return bad_mesh("t_junction: it lies inside the edge from vertex " +
                        std::to_string(hanging->edge.from) + " to vertex " +
                        std::to_string(hanging->edge.to) + " of quad " +
                        std::to_string(hanging->edge.face) + "; split that quad there",
                    "vertex", hanging->vertex);
}

Status check_overlap(const Quadrangulation& mesh) {
    const auto pair = find_overlap(mesh.quad_count(), [&](Index q) { return mesh.corners(q); });
    if (!pair) return {};
    return bad_mesh("overlap: its interior meets that of quad " + std::to_string((*pair)[1]) +
                        "; a surface over the plane needs disjoint quads",
                    "quad", (*pair)[0]);
}

double smallest_angle(const QuadCorners& v) {
    const Vec2 centre = diagonals(v).centre;
    const auto angle = [](Vec2 a, Vec2 b) { return std::atan2(std::abs(cross(a, b)), dot(a, b)); };
    double smallest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 4; ++i) {
        const Vec2 a = v[i];
        const Vec2 b = v[(i + 1) % 4];
        smallest = std::min({smallest, angle(b - a, centre - a), angle(centre - b, a - b),
                             angle(a - centre, b - centre)});
    }
    return smallest * 180 / 3.14159265358979323846;
}

std::vector<Warning> warnings(const Quadrangulation& mesh) {
    std::vector<Warning> found;
    for (Index q = 0; q < mesh.quad_count(); ++q) {
        const double degrees = smallest_angle(mesh.corners(q));
        if (degrees >= kSmallAngle) continue;
        found.push_back({q, degrees,
                         "small_angle: quad " + std::to_string(q) + " has an angle of " +
                             std::to_string(degrees) +
                             " degrees; coefficients there may be far larger than the surface"});
    }
    return found;
}

}  // namespace relief::mesh
