#include "mesh/quadrangulation_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/box_tree.h"

namespace relief::mesh {

namespace {

constexpr double kConvexity = 1e-10;
constexpr double kOnEdge = 1e-9;
constexpr double kTouching = 1e-9;  ///< overlaps thinner than this part of the smaller quad
constexpr double kSmallAngle = 1;   ///< degrees

double longest_side(const QuadCorners& v) {
    double longest = 0;
    for (int i = 0; i < 4; ++i) longest = std::max(longest, length(v[(i + 1) % 4] - v[i]));
    return longest;
}

/// Whether all of b lies to the right of some side of a.
bool side_separates(const QuadCorners& a, const QuadCorners& b, double margin) {
    for (int i = 0; i < 4; ++i) {
        const Vec2 along = a[(i + 1) % 4] - a[i];
        const double limit = margin * length(along);
        const bool outside = std::all_of(b.begin(), b.end(),
                                         [&](Vec2 p) { return cross(along, p - a[i]) <= limit; });
        if (outside) return true;
    }
    return false;
}

/// Convex polygons have disjoint interiors if and only if a side of one of them separates them.
bool interiors_meet(const QuadCorners& a, const QuadCorners& b) {
    const double margin = kTouching * std::min(longest_side(a), longest_side(b));
    return !side_separates(a, b, margin) && !side_separates(b, a, margin);
}

}  // namespace

Error bad_mesh(std::string message, const char* element, std::size_t number) {
    return {ErrorCode::BadInput, std::move(message),
            std::string(element) + " " + std::to_string(number)};
}

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
    std::vector<Box> boxes;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        boxes.push_back({mesh.vertex(v), mesh.vertex(v)});
    const BoxTree vertices(boxes);
    const auto sides = edge_quads(mesh);
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        if (sides[e][1] != kNoQuad) continue;
        const Vec2 from = mesh.vertex(mesh.edges[e][0]);
        const Vec2 along = mesh.edge_vector(e);
        const double squared = dot(along, along);
        const double margin = kOnEdge * std::sqrt(squared);
        const Box reach = box_of(std::array{from, from + along}).grown(margin);
        const auto near = [&](const Box& box) {
            return reach.meets(box) && box.meets_line(from, along, margin);
        };
        Index found = kNoQuad;
        vertices.search(near, [&](Index v) {
            const Vec2 to = mesh.vertex(v) - from;
            const double parameter = dot(to, along) / squared;
            const double distance = std::abs(cross(along, to)) / squared;
            if (distance <= kOnEdge && parameter > kOnEdge && parameter < 1 - kOnEdge)
                found = std::min(found, v);
        });
        if (found != kNoQuad)
            return bad_mesh("t_junction: it lies inside the edge from vertex " +
                                std::to_string(mesh.edges[e][0]) + " to vertex " +
                                std::to_string(mesh.edges[e][1]) + " of quad " +
                                std::to_string(sides[e][0]) + "; split that quad there",
                            "vertex", found);
    }
    return {};
}

Status check_overlap(const Quadrangulation& mesh) {
    std::vector<Box> boxes;
    for (Index q = 0; q < mesh.quad_count(); ++q) boxes.push_back(box_of(mesh.corners(q)));
    const BoxTree tree(boxes);
    for (Index q = 0; q < mesh.quad_count(); ++q) {
        const QuadCorners corners = mesh.corners(q);
        Index found = kNoQuad;
        tree.search([&](const Box& box) { return boxes[q].meets(box); },
                    [&](Index other) {
                        if (other <= q || other >= found || !boxes[q].meets(boxes[other])) return;
                        if (interiors_meet(corners, mesh.corners(other))) found = other;
                    });
        if (found != kNoQuad)
            return bad_mesh("overlap: its interior meets that of quad " + std::to_string(found) +
                                "; a surface over the plane needs disjoint quads",
                            "quad", q);
    }
    return {};
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
