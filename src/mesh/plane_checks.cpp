#include "mesh/plane_checks.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace relief::mesh {

namespace {

constexpr double kLargestCoordinate = 1e150;
constexpr double kOnEdge = 1e-9;
constexpr double kTouching = 1e-9;  ///< overlaps thinner than this part of the smaller polygon

double longest_side(std::span<const Vec2> corners) {
    double longest = 0;
    Vec2 before = corners.back();
    for (const Vec2 corner : corners) {
        longest = std::max(longest, length(corner - before));
        before = corner;
    }
    return longest;
}

/// Whether all of b lies to the right of some side of a.
bool side_separates(std::span<const Vec2> a, std::span<const Vec2> b, double margin) {
    Vec2 from = a.back();
    for (const Vec2 to : a) {
        const Vec2 along = to - from;
        const double limit = margin * length(along);
        if (std::all_of(b.begin(), b.end(),
                        [&](Vec2 p) { return cross(along, p - from) <= limit; }))
            return true;
        from = to;
    }
    return false;
}

}  // namespace

Error bad_mesh(std::string message, const char* element, std::size_t number) {
    return {ErrorCode::BadInput, std::move(message),
            std::string(element) + " " + std::to_string(number)};
}

Status check_coordinates(std::span<const Vec2> points, const char* name, const char* element) {
    const auto good = [](double t) { return std::abs(t) <= kLargestCoordinate; };
    const auto bad = std::find_if(points.begin(), points.end(),
                                  [&](Vec2 p) { return !good(p.x) || !good(p.y); });
    if (bad == points.end()) return {};
    return bad_mesh(
        std::string(name) + ": a coordinate is not finite or beyond 1e150; correct or remove it",
        element, static_cast<std::size_t>(bad - points.begin()));
}

std::optional<HangingVertex> find_hanging_vertex(std::span<const double> x,
                                                 std::span<const double> y,
                                                 std::span<const Index> vertices,
                                                 std::span<const BoundaryEdge> edges) {
    std::vector<Box> boxes;
    boxes.reserve(vertices.size());
    for (const Index v : vertices) boxes.push_back({{x[v], y[v]}, {x[v], y[v]}});
    const BoxTree tree(boxes);
    for (const BoundaryEdge& edge : edges) {
        const Vec2 from{x[edge.from], y[edge.from]};
        const Vec2 along = Vec2{x[edge.to], y[edge.to]} - from;
        const double squared = dot(along, along);
        const double margin = kOnEdge * std::sqrt(squared);
        const Box reach = box_of(std::array{from, from + along}).grown(margin);
        const auto reaches = [&](const Box& box) {
            return reach.meets(box) && box.meets_line(from, along, margin);
        };
        Index found = kNone;
        tree.search(reaches, [&](Index k) {
            const Vec2 to = boxes[k].low - from;
            const double parameter = dot(to, along) / squared;
            const double distance = std::abs(cross(along, to)) / squared;
            if (vertices[k] != edge.near && distance <= kOnEdge && parameter > kOnEdge &&
                parameter < 1 - kOnEdge)
                found = std::min(found, vertices[k]);
        });
        if (found != kNone) return HangingVertex{found, edge};
    }
    return std::nullopt;
}

/// Convex polygons have disjoint interiors if and only if a side of one of them separates them.
bool interiors_meet(std::span<const Vec2> a, std::span<const Vec2> b) {
    const double margin = kTouching * std::min(longest_side(a), longest_side(b));
    return !side_separates(a, b, margin) && !side_separates(b, a, margin);
}

}  // namespace relief::mesh
