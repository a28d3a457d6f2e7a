#include "relief/mesh/closest.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace relief::mesh {

namespace {

using Point = Vec3<double>;
using Corners = std::array<Point, 3>;

constexpr Index kLeafTriangles = 4;
/// Halving 2^31 triangles down to leaves takes fewer steps.
constexpr std::size_t kMostDepth = 32;

double squared_length(const Point& a) {
    return dot(a, a);
}

Point closest_on_segment(const Point& a, const Point& b, const Point& p) {
    const Point side = b - a;
    const double square = squared_length(side);
    if (!(square > 0)) return a;
    return a + std::clamp(dot(p - a, side) / square, 0.0, 1.0) * side;
}

/// The same triangle with its longest side from corner 0 to corner 1.
Corners longest_first(const Corners& t) {
    const std::array<double, 3> squares = {squared_length(t[1] - t[0]), squared_length(t[2] - t[1]),
                                           squared_length(t[0] - t[2])};
    const auto k = static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) -
                                            squares.begin());
    return {t[k], t[(k + 1) % 3], t[(k + 2) % 3]};
}

/// Below the point along the longest side and the height on it, which are orthogonal: so a thin
/// triangle magnifies no rounding. Otherwise the closest point is on a side.
Point closest_on(const Corners& t, const Point& p) {
    const Point base = t[1] - t[0];
    const double base2 = squared_length(base);
    if (!(base2 > 0)) return t[0];
    const double foot = dot(t[2] - t[0], base) / base2;
    const Point height = (t[2] - t[0]) - foot * base;
    const double height2 = squared_length(height);
    std::array<bool, 3> sees = {true, true, true};  // which sides p is beyond
    if (height2 > 0) {
        const double along = dot(p - t[0], base) / base2;
        const double up = dot(p - t[0], height) / height2;
        sees = {!(up >= 0), !(1 - along >= up * (1 - foot)), !(along >= up * foot)};
        if (!sees[0] && !sees[1] && !sees[2]) return t[0] + along * base + up * height;
    }
    Point best = t[0];
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        if (!sees[k]) continue;
        const Point q = closest_on_segment(t[k], t[(k + 1) % 3], p);
        const double square = squared_length(p - q);
        if (square >= least) continue;
        least = square;
        best = q;
    }
    return best;
}

}  // namespace

std::vector<FanTriangle> fan_triangles(const PolygonMesh& mesh) {
    const auto at = [&](std::int32_t v) {
        const auto& p = mesh.vertices[static_cast<std::size_t>(v)];
        return Point{p[0], p[1], p[2]};
    };
    std::vector<FanTriangle> triangles;
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
        const auto corners = mesh.polygon(f);
        for (std::size_t k = 1; k + 1 < corners.size(); ++k)
            triangles.push_back(
                {{at(corners[0]), at(corners[k]), at(corners[k + 1])}, static_cast<Index>(f)});
    }
    return triangles;
}

Point closest_point(const Corners& triangle, const Point& p) {
    return closest_on(longest_first(triangle), p);
}

void TriangleTree::Box::include(const std::array<double, 3>& p) {
    for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
    }
}

void TriangleTree::Box::include(const Box& box) {
    include(box.low);
    include(box.high);
}

double TriangleTree::Box::squared_distance(const Point& p) const {
    const auto beyond = [](double least, double value, double most) {
        return std::max(0.0, std::max(least - value, value - most));
    };
    const double x = beyond(low[0], p.x, high[0]);
    const double y = beyond(low[1], p.y, high[1]);
    const double z = beyond(low[2], p.z, high[2]);
    return x * x + y * y + z * z;
}

struct TriangleTree::Item {
    std::array<double, 3> centre;  ///< of its box, doubled
    Index triangle;
};

TriangleTree::TriangleTree(const std::vector<FanTriangle>& triangles) {
    if (triangles.empty()) return;
    std::vector<Item> items(triangles.size());
    for (Index k = 0; k < items.size(); ++k) {
        const auto& [a, b, c] = triangles[k].corners;
        const auto middle = [](double x, double y, double z) {
            return std::min({x, y, z}) + std::max({x, y, z});
        };
        items[k] = {{middle(a.x, b.x, c.x), middle(a.y, b.y, c.y), middle(a.z, b.z, c.z)}, k};
    }
    nodes_.reserve(triangles.size());
    build(triangles, items, 0, static_cast<Index>(items.size()));
    triangles_.reserve(items.size());
    for (const Item& item : items) {
        const auto& [corners, face] = triangles[item.triangle];
        triangles_.push_back({longest_first(corners), face});
    }
}

/// Halves the items across the longest side of the box of their centres.
void TriangleTree::build(const std::vector<FanTriangle>& triangles, std::vector<Item>& items,
                         Index begin, Index end) {
    const std::size_t self = nodes_.size();
    nodes_.push_back({{}, begin, end, 0});
    Box box;
    if (end - begin <= kLeafTriangles) {
        for (Index k = begin; k < end; ++k)
            for (const Point& p : triangles[items[k].triangle].corners)
                box.include(std::array{p.x, p.y, p.z});
        nodes_[self].box = box;
        return;
    }
    Box centres;
    for (Index k = begin; k < end; ++k) centres.include(items[k].centre);
    const auto size = [&](std::size_t axis) { return centres.high[axis] - centres.low[axis]; };
    std::size_t axis = size(1) > size(0) ? 1 : 0;
    if (size(2) > size(axis)) axis = 2;
    const Index middle = begin + (end - begin) / 2;
    std::nth_element(items.begin() + begin, items.begin() + middle, items.begin() + end,
                     [axis](const Item& a, const Item& b) {
                         return a.centre[axis] != b.centre[axis] ? a.centre[axis] < b.centre[axis]
                                                                 : a.triangle < b.triangle;
                     });
    build(triangles, items, begin, middle);
    const std::size_t second = nodes_.size();
    build(triangles, items, middle, end);
    box.include(nodes_[self + 1].box);
    box.include(nodes_[second].box);
    nodes_[self].box = box;
    nodes_[self].second = static_cast<Index>(second);
}

SurfacePoint TriangleTree::closest(const Point& p, double enough) const {
    const SurfacePoint first{triangles_[0].corners[0], 0, triangles_[0].face, 0};
    return search(first, squared_length(p - first.point), p, enough);
}

SurfacePoint TriangleTree::closest_from(Index first, const Point& p, double enough) const {
    const FanTriangle& triangle = triangles_[first];
    const Point q = closest_on(triangle.corners, p);
    return search({q, 0, triangle.face, first}, squared_length(p - q), p, enough);
}

/// From what is known, which is at the squared distance `least`.
SurfacePoint TriangleTree::search(SurfacePoint best, double least, const Point& p,
                                  double enough) const {
    struct Waiting {
        Index node;
        double bound;
    };
    std::array<Waiting, kMostDepth> stack;
    std::size_t waiting = 0;
    Index node = 0;
    double bound = 0;
    while (least > enough * enough) {
        if (bound < least) {
            const Node& here = nodes_[node];
            if (here.second != 0) {
                Waiting near{node + 1, nodes_[node + 1].box.squared_distance(p)};
                Waiting far{here.second, nodes_[here.second].box.squared_distance(p)};
                if (far.bound < near.bound) std::swap(near, far);
                stack[waiting++] = far;
                node = near.node;
                bound = near.bound;
                continue;
            }
            for (Index k = here.begin; k < here.end; ++k) {
                const Point q = closest_on(triangles_[k].corners, p);
                const double square = squared_length(p - q);
                if (square >= least) continue;
                least = square;
                best = {q, 0, triangles_[k].face, k};
            }
        }
        if (waiting == 0) break;
        node = stack[--waiting].node;
        bound = stack[waiting].bound;
    }
    best.distance = std::sqrt(least);
    return best;
}

}  // namespace relief::mesh
