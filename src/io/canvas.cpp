#include "io/canvas.h"

#include <algorithm>
#include <cmath>

#include "relief/core/parallel.h"

namespace relief::io::detail {

namespace {

/// The samples whose centres lie between `low` and `high` pixels, within 0 .. count - 1.
std::array<int, 2> span(double low, double high, int count) {
    const auto clamp = [&](double t) {
        return static_cast<int>(std::clamp(t, -1.0, static_cast<double>(count)));
    };
    return {std::max(0, clamp(std::ceil(low - 0.5))),
            std::min(count - 1, clamp(std::floor(high - 0.5)))};
}

ScreenPoint in_samples(const ScreenPoint& p) {
    return {p.x * Canvas::kSamples, p.y * Canvas::kSamples, p.nearness};
}

}  // namespace

Canvas::Canvas(int width, int height)
    : width_(width * kSamples),
      height_(height * kSamples),
      samples_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {}

void Canvas::triangle(const std::array<ScreenPoint, 3>& points,
                      const std::array<Light, 3>& colours) {
    const ScreenPoint a = in_samples(points[0]);
    const ScreenPoint b = in_samples(points[1]);
    const ScreenPoint c = in_samples(points[2]);
    const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (!(std::abs(area) > 0)) return;
    const auto [y0, y1] = span(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), height_);
    const auto [x0, x1] = span(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), width_);
    for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
            const double px = x + 0.5;
            const double py = y + 0.5;
            const double u = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / area;
            const double v = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / area;
            const double w = 1 - u - v;
            constexpr double slack = -1e-9;  // no gaps between neighbours
            if (u < slack || v < slack || w < slack) continue;
            Light light;
            for (std::size_t k = 0; k < 3; ++k)
                light[k] = w * colours[0][k] + u * colours[1][k] + v * colours[2][k];
            const auto nearness =
                static_cast<float>(w * a.nearness + u * b.nearness + v * c.nearness);
            Sample& s = sample(x, y);
            if (nearness <= s.nearness) continue;
            s.nearness = nearness;
            s.colour = srgb_of(light);
            s.covered = true;
        }
    }
}

void Canvas::line(const ScreenPoint& from, const ScreenPoint& to, double width, const Pen& pen) {
    const ScreenPoint a = in_samples(from);
    const ScreenPoint b = in_samples(to);
    const double radius = width * kSamples / 2;
    const double dx = b.x - a.x;
    const double dy = b.y - a.y;
    const double length2 = dx * dx + dy * dy;
    const auto [y0, y1] = span(std::min(a.y, b.y) - radius, std::max(a.y, b.y) + radius, height_);
    const auto [x0, x1] = span(std::min(a.x, b.x) - radius, std::max(a.x, b.x) + radius, width_);
    for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
            const double px = x + 0.5 - a.x;
            const double py = y + 0.5 - a.y;
            const double t =
                length2 > 0 ? std::clamp((px * dx + py * dy) / length2, 0.0, 1.0) : 0.0;
            const double off2 = (px - t * dx) * (px - t * dx) + (py - t * dy) * (py - t * dy);
            if (off2 > radius * radius) continue;
            const double nearness = a.nearness + t * (b.nearness - a.nearness);
            Sample& s = sample(x, y);
            const bool hidden = nearness * (1 + pen.lift) <= static_cast<double>(s.nearness);
            const auto opacity = static_cast<float>(hidden ? pen.hidden_opacity : pen.opacity);
            if (opacity <= s.opacity) continue;
            s.opacity = opacity;
            s.ink = pen.colour;
        }
    }
}

Image Canvas::image(int channels) const {
    constexpr int all = kSamples * kSamples;
    Image out(width_ / kSamples, height_ / kSamples, channels);
    const auto average = [&](int row, int col, std::uint8_t* p) {
        Light sum = {};
        double cover = 0;
        for (int k = 0; k < all; ++k) {
            const Sample& s = sample(col * kSamples + k % kSamples, row * kSamples + k / kSamples);
            const double ink = static_cast<double>(s.opacity);
            const double behind = s.covered || channels == 3 ? 1 - ink : 0;
            for (std::size_t i = 0; i < 3; ++i)
                sum[i] += ink * linear_of(s.ink[i]) + behind * linear_of(s.colour[i]);
            cover += ink + behind;
        }
        for (std::size_t i = 0; i < 3; ++i) p[i] = code_of(cover > 0 ? sum[i] / cover : 0);
        if (channels == 4) p[3] = static_cast<std::uint8_t>(std::lround(255 * cover / all));
    };
    parallel_for(0, out.height, 16, [&](std::int64_t first, std::int64_t last) {
        for (auto r = static_cast<int>(first); r < static_cast<int>(last); ++r)
            for (int c = 0; c < out.width; ++c) average(r, c, out.pixel(r, c));
    });
    return out;
}

}  // namespace relief::io::detail
