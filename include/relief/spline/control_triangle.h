#pragma once

#include <array>
#include <optional>
#include <span>

#include "relief/core/vec2.h"

namespace relief::spline {

/// The barycentric coordinates of a point, each as a quotient of areas: exactly 1, 0, 0 at the
/// corners. Requires: the corners are not collinear.
[[nodiscard]] constexpr std::array<double, 3> barycentric(const TriangleCorners& t, Vec2 point) {
    const double area = orient(t[0], t[1], t[2]);
    return {orient(point, t[1], t[2]) / area, orient(point, t[2], t[0]) / area,
            orient(point, t[0], t[1]) / area};
}

/// The triangle of smallest area that contains the points; it is not unique, its area is. Points
/// lie inside up to 1e-13 of their extent. Nothing if they are collinear (to 1e-13 of their
/// extent) or not finite.
/// Complexity: O(h^3) for h points on the hull. Source: powell-sabin.md section 5.
[[nodiscard]] std::optional<TriangleCorners> smallest_triangle(std::span<const Vec2> points);

}  // namespace relief::spline
