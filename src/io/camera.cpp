#include "io/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace relief::io::detail {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMargin = 0.03;  ///< of the picture's width, on each side

}  // namespace

Vec direction(double azimuth, double altitude) {
    const double flat = std::cos(altitude * kDegree);
    return {std::sin(azimuth * kDegree) * flat, std::cos(azimuth * kDegree) * flat,
            std::sin(altitude * kDegree)};
}

void Box::add(const Vec& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
}

Camera::Camera(const Box& box, const Viewpoint& from)
    : middle_(0.5 * box.low + 0.5 * box.high),
      right_(direction(from.azimuth - 90, 0)),
      towards_viewer_(direction(from.azimuth, from.altitude)) {
    up_ = cross(towards_viewer_, right_);
    // Halves and quotients, so that nothing overflows.
    const Vec half = 0.5 * box.high - 0.5 * box.low;
    const double longest = std::max({half.x, half.y, half.z, 1e-300});
    radius_ = std::max(longest * length((1 / longest) * half), 1e-300);
    const double half_angle = std::clamp(from.field_of_view, 0.0, 120.0) / 2 * kDegree;
    if (half_angle > 0) distance_ = 1 / std::sin(half_angle);
}

ScreenPoint Camera::project(const Vec& p) const {
    const Vec d = place(p);
    const double towards = dot(d, towards_viewer_);
    const double shrink = distance_ ? *distance_ / (*distance_ - towards) : 1;
    return {dot(d, right_) * shrink, -dot(d, up_) * shrink, distance_ ? shrink : 1 + towards / 4};
}

Fit fitted(const Box& seen, int width) {
    const double across = std::max(seen.high.x - seen.low.x, 1e-300);
    const double down = seen.high.y - seen.low.y;
    const double margin = kMargin * width;
    Fit out;
    out.width = width;
    out.scale = (width - 2 * margin) / across;
    // A tall narrow scene must not become a picture of any height.
    if (down * out.scale > 2.0 * width) out.scale = 2.0 * width / down;
    out.height = static_cast<int>(std::ceil(down * out.scale + 2 * margin));
    out.x = width / 2.0 - (seen.low.x + seen.high.x) / 2 * out.scale;
    out.y = out.height / 2.0 - (seen.low.y + seen.high.y) / 2 * out.scale;
    return out;
}

}  // namespace relief::io::detail
