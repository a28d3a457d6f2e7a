#pragma once

#include <algorithm>
#include <cmath>

#include "relief/core/vec3.h"

/// Angles by additions, multiplications and divisions alone: the same bits on every processor,
/// which the functions of the C library do not promise.
namespace relief::remesh {

inline constexpr double kPi = 3.14159265358979323846;

/// The angle of a point of the first two quadrants, from 0 to pi; off by less than 1e-9. Requires:
/// y >= 0, not both 0.
[[nodiscard]] inline double angle_of(double x, double y) {
    // atan t = 2 atan(t / (1 + sqrt(1 + t^2))), twice: then |t| <= tan(pi/16).
    const double large = std::max(std::abs(x), y);
    double t = std::min(std::abs(x), y) / large;
    t = t / (1 + std::sqrt(1 + t * t));
    t = t / (1 + std::sqrt(1 + t * t));
    const double s = t * t;
    const double series =
        t * (1 - s * (1.0 / 3 - s * (1.0 / 5 - s * (1.0 / 7 - s * (1.0 / 9 - s / 11)))));
    const double acute = 4 * series;
    const double quadrant = std::abs(x) < y ? kPi / 2 - acute : acute;
    return x < 0 ? kPi - quadrant : quadrant;
}

/// Between two vectors, from 0 to pi. Requires: neither is 0.
[[nodiscard]] inline double angle_between(const Vec3<double>& a, const Vec3<double>& b) {
    return angle_of(dot(a, b), length(cross(a, b)));
}

struct Direction {
    double x = 1;
    double y = 0;
};

/// (cos, sin) of an angle from 0 to 2 pi; off by less than 1e-9.
[[nodiscard]] inline Direction direction_of(double angle) {
    // The direction of a quarter of what is beyond pi, doubled twice.
    const double a = (angle - kPi) / 4;
    const double s = a * a;
    double x = 1 - s / 2 * (1 - s / 12 * (1 - s / 30 * (1 - s / 56 * (1 - s / 90))));
    double y = a * (1 - s / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110)))));
    for (int k = 0; k < 2; ++k) {
        const double doubled = 2 * x * y;
        x = x * x - y * y;
        y = doubled;
    }
    return {-x, -y};
}

}  // namespace relief::remesh
