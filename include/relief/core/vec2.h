#pragma once

#include <array>
#include <cmath>

/// Points and vectors of the plane, triangles and convex quads. Only operations that IEEE 754
/// rounds correctly are used, so results are the same on every machine.
namespace relief {

struct Vec2 {
    double x = 0;
    double y = 0;

    friend bool operator==(const Vec2&, const Vec2&) = default;
};

[[nodiscard]] constexpr Vec2 operator+(Vec2 a, Vec2 b) {
    return {a.x + b.x, a.y + b.y};
}
[[nodiscard]] constexpr Vec2 operator-(Vec2 a, Vec2 b) {
    return {a.x - b.x, a.y - b.y};
}
[[nodiscard]] constexpr Vec2 operator*(double s, Vec2 a) {
    return {s * a.x, s * a.y};
}
[[nodiscard]] constexpr double dot(Vec2 a, Vec2 b) {
    return a.x * b.x + a.y * b.y;
}
/// The z component of the cross product: positive if b lies to the left of a.
[[nodiscard]] constexpr double cross(Vec2 a, Vec2 b) {
    return a.x * b.y - a.y * b.x;
}
/// Turned by +90 degrees.
[[nodiscard]] constexpr Vec2 turned(Vec2 a) {
    return {-a.y, a.x};
}
[[nodiscard]] inline double length(Vec2 a) {
    return std::sqrt(dot(a, a));
}
/// The vector of length 1 in the direction of a. Requires: a is not zero.
[[nodiscard]] inline Vec2 unit(Vec2 a) {
    const double norm = length(a);
    return {a.x / norm, a.y / norm};
}
[[nodiscard]] constexpr Vec2 midpoint(Vec2 a, Vec2 b) {
    return {0.5 * (a.x + b.x), 0.5 * (a.y + b.y)};
}

/// Twice the signed area of a triangle: positive if its corners run counter-clockwise.
[[nodiscard]] constexpr double orient(Vec2 a, Vec2 b, Vec2 c) {
    return cross(b - a, c - a);
}

/// The corners of a triangle, counter-clockwise. Side k runs from corner k to corner k + 1 (mod 3).
using TriangleCorners = std::array<Vec2, 3>;

/// The corners of a quad, counter-clockwise. Side i runs from corner i to corner i + 1 (mod 4).
using QuadCorners = std::array<Vec2, 4>;

/// Where the diagonals of a quad meet: centre = (1-s) v0 + s v2 = (1-t) v1 + t v3.
struct Diagonals {
    Vec2 centre;
    double s = 0;
    double t = 0;
};

/// Requires: v is strictly convex and counter-clockwise; then s and t lie in (0, 1).
[[nodiscard]] constexpr Diagonals diagonals(const QuadCorners& v) {
    const Vec2 d1 = v[2] - v[0];
    const Vec2 d2 = v[3] - v[1];
    const double both = cross(d1, d2);
    const double s = cross(v[1] - v[0], d2) / both;
    const double t = cross(v[1] - v[0], d1) / both;
    return {v[0] + s * d1, s, t};
}

/// Twice the signed area.
[[nodiscard]] constexpr double doubled_area(const QuadCorners& v) {
    return cross(v[2] - v[0], v[3] - v[1]);
}

}  // namespace relief
