#pragma once

#include <optional>

#include "io/canvas.h"
#include "relief/core/vec3.h"

/// Perspective for pictures of things in space, x east, y north, z up.
namespace relief::io::detail {

using Vec = Vec3<double>;

/// The unit vector at an azimuth (clockwise from north) and altitude, in degrees.
[[nodiscard]] Vec direction(double azimuth, double altitude);

/// Empty until something is added.
struct Box {
    Vec low = {1e300, 1e300, 1e300};
    Vec high = {-1e300, -1e300, -1e300};

    void add(const Vec& p);
    void add(const ScreenPoint& p) { add(Vec{p.x, p.y, 0}); }
    [[nodiscard]] bool empty() const { return low.x > high.x; }
};

/// Where the viewer stands, and how wide he sees.
struct Viewpoint {
    double azimuth = 0;        ///< degrees clockwise from north
    double altitude = 0;       ///< degrees above the horizon
    double field_of_view = 0;  ///< degrees; 0: parallel projection
};

/// Looks at the middle of a box from a distance at which its diagonal fills the field of view. All
/// lengths are in units of half this diagonal.
class Camera {
  public:
    /// Requires: a box that is not empty.
    Camera(const Box& box, const Viewpoint& from);

    /// Relative to the middle.
    [[nodiscard]] Vec place(const Vec& p) const { return (1 / radius_) * (p - middle_); }
    /// The middle at (0, 0), y down.
    [[nodiscard]] ScreenPoint project(const Vec& p) const;

    [[nodiscard]] const Vec& right() const { return right_; }
    [[nodiscard]] const Vec& up() const { return up_; }
    [[nodiscard]] const Vec& towards_viewer() const { return towards_viewer_; }
    /// From the middle; none: parallel projection.
    [[nodiscard]] std::optional<double> distance() const { return distance_; }

  private:
    Vec middle_{};
    Vec right_{};
    Vec up_{};
    Vec towards_viewer_{};
    double radius_ = 1;
    std::optional<double> distance_;
};

/// From what a camera projects to pixels.
struct Fit {
    double scale = 1;
    double x = 0;
    double y = 0;
    int width = 0;
    int height = 0;

    [[nodiscard]] ScreenPoint operator()(const ScreenPoint& p) const {
        return {p.x * scale + x, p.y * scale + y, p.nearness};
    }
};

/// A picture of `width` pixels around all that is seen, at most about twice as high.
[[nodiscard]] Fit fitted(const Box& seen, int width);

}  // namespace relief::io::detail
