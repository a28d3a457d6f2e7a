#include "relief/spline/control_triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace relief::spline {

namespace {

constexpr double kFlat = 1e-13;  ///< for coordinates between -1 and 1
constexpr double kParallel = 1e-12;
constexpr double kAtApex = 1e-14;

/// The corners of the convex hull, counter-clockwise from the leftmost; sorts the points.
std::vector<Vec2> convex_hull(std::vector<Vec2>& points) {
    std::sort(points.begin(), points.end(),
              [](Vec2 a, Vec2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
    std::vector<Vec2> hull;
    const auto add = [&hull](Vec2 p, std::size_t fixed) {
        while (hull.size() > fixed && orient(hull[hull.size() - 2], hull.back(), p) <= 0)
            hull.pop_back();
        hull.push_back(p);
    };
    for (const Vec2 p : points) add(p, 1);
    const std::size_t lower = hull.size();
    for (auto p = points.rbegin() + 1; p != points.rend(); ++p) add(*p, lower);
    hull.pop_back();
    return hull;
}

/// Without the corners at which the hull hardly turns. This can not be done while the hull is
/// found: among points whose abscissae differ by rounding only, it would lose true corners.
std::vector<Vec2> without_flat_corners(const std::vector<Vec2>& hull) {
    std::vector<Vec2> kept;
    const auto flat = [&kept](std::size_t a, std::size_t b, Vec2 c) {
        return orient(kept[a], kept[b], c) <= kFlat;
    };
    for (const Vec2 p : hull) {
        while (kept.size() > 1 && flat(kept.size() - 2, kept.size() - 1, p)) kept.pop_back();
        kept.push_back(p);
    }
    while (kept.size() > 2 && flat(kept.size() - 2, kept.size() - 1, kept[0])) kept.pop_back();
    while (kept.size() > 2 && flat(kept.size() - 1, 0, kept[1])) kept.erase(kept.begin());
    return kept;
}

/// Encloses a polygon by wedges between the lines of two of its edges, cut by a third line. In the
/// coordinates of a wedge, p = apex + s d1 + t d2, the third line is u s + v t = m and the area
/// |d1 x d2| m^2 / (2 u v).
class WedgeSearch {
  public:
    explicit WedgeSearch(const std::vector<Vec2>& hull) : hull_(hull), place_(hull.size()) {}

    TriangleCorners best() {
        for (std::size_t i = 0; i < hull_.size(); ++i)
            for (std::size_t j = i + 1; j < hull_.size(); ++j) try_wedge(i, j);
        return best_;
    }

  private:
    [[nodiscard]] std::size_t after(std::size_t p) const {
        return p + 1 < hull_.size() ? p + 1 : 0;
    }
    [[nodiscard]] std::size_t before(std::size_t p) const {
        return p > 0 ? p - 1 : hull_.size() - 1;
    }

    void try_wedge(std::size_t i, std::size_t j) {
        d1_ = unit(hull_[after(i)] - hull_[i]);
        d2_ = unit(hull_[after(j)] - hull_[j]);
        if (std::abs(cross(d1_, d2_)) < kParallel) return;
        apex_ = hull_[i] + (cross(hull_[j] - hull_[i], d2_) / cross(d1_, d2_)) * d1_;
        if (dot(midpoint(hull_[i], hull_[after(i)]) - apex_, d1_) < 0) d1_ = -1 * d1_;
        if (dot(midpoint(hull_[j], hull_[after(j)]) - apex_, d2_) < 0) d2_ = -1 * d2_;
        if (cross(d1_, d2_) < 0) std::swap(d1_, d2_);
        area_ = cross(d1_, d2_);
        for (std::size_t p = 0; p < hull_.size(); ++p) {
            const Vec2 from_apex = hull_[p] - apex_;
            place_[p] = {std::max(cross(from_apex, d2_) / area_, 0.0),
                         std::max(cross(d1_, from_apex) / area_, 0.0)};
        }
        for (std::size_t p = 0; p < hull_.size(); ++p) {
            const Vec2 here = place_[p];
            const Vec2 along = place_[after(p)] - here;
            if (here.x > kAtApex && here.y > kAtApex) try_line({1 / here.x, 1 / here.y}, p, p);
            try_line({along.y, -along.x}, p, after(p));
        }
    }

    /// The line through hull corner p, or through p and the corner after it. A convex polygon lies
    /// on one side of it if its neighbours do.
    void try_line(Vec2 uv, std::size_t p, std::size_t last) {
        if (!(uv.x > 0 && uv.y > 0)) return;
        double m = dot(uv, place_[p]);
        const double allowed = m * (1 + 1e-9);
        if (dot(uv, place_[before(p)]) > allowed || dot(uv, place_[after(last)]) > allowed) return;
        const double scale = area_ / (2 * uv.x * uv.y);
        if (!(scale * m * m < smallest_ * (1 - 1e-12))) return;
        for (const Vec2 q : place_) m = std::max(m, dot(uv, q));
        if (!(scale * m * m < smallest_ * (1 - 1e-12))) return;
        smallest_ = scale * m * m;
        best_ = {apex_, apex_ + (m / uv.x) * d1_, apex_ + (m / uv.y) * d2_};
    }

    const std::vector<Vec2>& hull_;
    std::vector<Vec2> place_;  ///< (s, t) of the hull's corners
    Vec2 apex_;
    Vec2 d1_;
    Vec2 d2_;
    double area_ = 0;  ///< d1 x d2, positive
    double smallest_ = std::numeric_limits<double>::infinity();
    TriangleCorners best_;
};

}  // namespace

std::optional<TriangleCorners> smallest_triangle(std::span<const Vec2> points) {
    Vec2 mean;
    for (const Vec2 p : points) mean = mean + p;
    mean = (1 / static_cast<double>(points.size())) * mean;
    if (!std::isfinite(mean.x) || !std::isfinite(mean.y)) return std::nullopt;
    double extent = 0;
    for (const Vec2 p : points)
        extent = std::max({extent, std::abs(p.x - mean.x), std::abs(p.y - mean.y)});
    if (extent == 0) return std::nullopt;
    std::vector<Vec2> scaled;
    for (const Vec2 p : points)
        scaled.push_back({(p.x - mean.x) / extent, (p.y - mean.y) / extent});
    const std::vector<Vec2> hull = without_flat_corners(convex_hull(scaled));
    if (hull.size() < 3) return std::nullopt;
    TriangleCorners triangle =
        hull.size() == 3 ? TriangleCorners{hull[0], hull[1], hull[2]} : WedgeSearch(hull).best();
    for (Vec2& corner : triangle) corner = mean + extent * corner;
    return triangle;
}

}  // namespace relief::spline
