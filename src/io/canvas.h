#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "io/colour.h"
#include "relief/io/image.h"

namespace relief::io::detail {

/// A projected point: pixels right and down, and nearness (larger is nearer; linear along straight
/// lines).
struct ScreenPoint {
    double x, y, nearness;
};

/// What a line looks like.
struct Pen {
    Srgb colour = {};
    double opacity = 1;
    double hidden_opacity = 0;
    /// Brings the line nearer by this part of its nearness, above the surface it lies on.
    double lift = 0;
    /// Samples around in which the surface may be as far as the line: steep slopes cut no line that
    /// lies on them.
    int reach = 0;
};

/// How much each corner of a triangle counts at a point of it; the sum is 1.
using CornerWeights = std::array<double, 3>;

/// An image of kSamples x kSamples samples a pixel with a depth buffer, or some rows of one: what
/// falls outside is cut.
class Canvas {
  public:
    static constexpr int kSamples = 3;

    /// Rows `top` .. `top` + height - 1 of a picture.
    Canvas(int width, int height, int top = 0);

    /// Fills a triangle; colour(weights of its corners on the screen) is asked where nothing is
    /// nearer.
    template <class Colour>
    void triangle(const std::array<ScreenPoint, 3>& p, Colour&& colour);
    /// Colours are blended between the corners.
    void triangle(const std::array<ScreenPoint, 3>& p, const std::array<Light, 3>& colours);
    /// A line of `width` pixels with round ends, opaque to `opacity` where nothing is nearer than
    /// it, to `hidden_opacity` elsewhere; lines that cross do not darken each other.
    void line(const ScreenPoint& a, const ScreenPoint& b, double width, const Pen& pen);

    /// The samples averaged in linear light; 3 channels: on white; 4: with alpha. Requires: top =
    /// 0.
    [[nodiscard]] Image image(int channels) const;
    /// The same of rows first .. end - 1 of the canvas, written to where they are in the picture.
    void write_rows(int first, int end, Image& picture) const;

  private:
    struct Sample {
        float nearness = -1e30F;  ///< of the surface
        float opacity = 0;        ///< of the line over it
        Srgb colour = {255, 255, 255};
        Srgb ink = {};
        bool covered = false;
    };

    [[nodiscard]] Sample& sample(int x, int y) {
        return samples_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                        static_cast<std::size_t>(x)];
    }
    [[nodiscard]] const Sample& sample(int x, int y) const {
        return const_cast<Canvas*>(this)->sample(x, y);
    }

    /// The least nearness of the surface up to `reach` samples around; where there is none, none.
    [[nodiscard]] float least_near(int x, int y, int reach) const;

    /// Samples first .. last of a row or column.
    struct Span {
        int first, last;
    };
    /// Those whose centres lie between two places, within 0 .. count - 1.
    [[nodiscard]] static Span between(double low, double high, int count);
    [[nodiscard]] ScreenPoint in_samples(const ScreenPoint& p) const {
        return {p.x * kSamples, (p.y - top_) * kSamples, p.nearness};
    }

    int width_;  ///< in samples
    int height_;
    int top_;  ///< in pixels
    std::vector<Sample> samples_;
};

template <class Colour>
void Canvas::triangle(const std::array<ScreenPoint, 3>& points, Colour&& colour) {
    const ScreenPoint a = in_samples(points[0]);
    const ScreenPoint b = in_samples(points[1]);
    const ScreenPoint c = in_samples(points[2]);
    const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (!(std::abs(area) > 0)) return;
    const Span rows = between(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), height_);
    for (int y = rows.first; y <= rows.last; ++y) {
        const double py = y + 0.5;
        double left = 1e300;
        double right = -1e300;
        const auto cross_row = [&](const ScreenPoint& p, const ScreenPoint& q) {
            const bool beside = (p.y < py && q.y < py) || (p.y > py && q.y > py);
            if (beside || p.y == q.y) return;  // the other sides meet the ends of a level one
            const double x = p.x + (py - p.y) / (q.y - p.y) * (q.x - p.x);
            left = std::min(left, x);
            right = std::max(right, x);
        };
        cross_row(a, b);
        cross_row(b, c);
        cross_row(c, a);
        // One sample more on each side: the weights decide.
        const Span columns = between(left - 1, right + 1, width_);
        for (int x = columns.first; x <= columns.last; ++x) {
            const double px = x + 0.5;
            const double u = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / area;
            const double v = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / area;
            const double w = 1 - u - v;
            constexpr double slack = -1e-9;  // no gaps between neighbours
            if (u < slack || v < slack || w < slack) continue;
            const auto nearness =
                static_cast<float>(w * a.nearness + u * b.nearness + v * c.nearness);
            Sample& s = sample(x, y);
            if (nearness <= s.nearness) continue;
            s.nearness = nearness;
            s.colour = colour(CornerWeights{w, u, v});
            s.covered = true;
        }
    }
}

}  // namespace relief::io::detail
