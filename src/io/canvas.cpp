#include "io/canvas.h"

#include <algorithm>
#include <cmath>

#include "relief/core/parallel.h"

namespace relief::io::detail {

Canvas::Canvas(int width, int height, int top)
    : width_(width * kSamples),
      height_(height * kSamples),
      top_(top),
      samples_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {}

Canvas::Span Canvas::between(double low, double high, int count) {
    const auto clamp = [&](double t) {
        return static_cast<int>(std::clamp(t, -1.0, static_cast<double>(count)));
    };
    return {std::max(0, clamp(std::ceil(low - 0.5))),
            std::min(count - 1, clamp(std::floor(high - 0.5)))};
}

void Canvas::triangle(const std::array<ScreenPoint, 3>& points,
                      const std::array<Light, 3>& colours) {
    triangle(points, [&](const CornerWeights& weights) {
        Light light;
        for (std::size_t k = 0; k < 3; ++k)
            light[k] = weights[0] * colours[0][k] + weights[1] * colours[1][k] +
                       weights[2] * colours[2][k];
        return srgb_of(light);
    });
}

float Canvas::least_near(int x, int y, int reach) const {
    float least = sample(x, y).nearness;
    if (!sample(x, y).covered) return least;
    for (int row = std::max(y - reach, 0); row <= std::min(y + reach, height_ - 1); ++row)
        for (int col = std::max(x - reach, 0); col <= std::min(x + reach, width_ - 1); ++col)
            if (sample(col, row).covered) least = std::min(least, sample(col, row).nearness);
    return least;
}

void Canvas::line(const ScreenPoint& from, const ScreenPoint& to, double width, const Pen& pen) {
    const ScreenPoint a = in_samples(from);
    const ScreenPoint b = in_samples(to);
    const double radius = width * kSamples / 2 + 0.5;  // of samples that are covered in part
    const double dx = b.x - a.x;
    const double dy = b.y - a.y;
    const double length2 = dx * dx + dy * dy;
    const Span rows = between(std::min(a.y, b.y) - radius, std::max(a.y, b.y) + radius, height_);
    for (int y = rows.first; y <= rows.last; ++y) {
        // The part of the line that is within the radius of the row.
        const auto part = [&](double py) {
            return dy != 0 ? std::clamp((py - a.y) / dy, 0.0, 1.0) : 0.0;
        };
        const double from_x = a.x + part(y + 0.5 - radius) * dx;
        const double to_x = dy != 0 ? a.x + part(y + 0.5 + radius) * dx : b.x;
        const Span columns = between(std::min(from_x, to_x) - radius - 1,
                                     std::max(from_x, to_x) + radius + 1, width_);
        for (int x = columns.first; x <= columns.last; ++x) {
            const double px = x + 0.5 - a.x;
            const double py = y + 0.5 - a.y;
            const double t =
                length2 > 0 ? std::clamp((px * dx + py * dy) / length2, 0.0, 1.0) : 0.0;
            const double off =
                std::sqrt((px - t * dx) * (px - t * dx) + (py - t * dy) * (py - t * dy));
            const double cover = std::min(radius - off, 1.0);
            if (cover <= 0) continue;
            const double nearness = a.nearness + t * (b.nearness - a.nearness);
            Sample& s = sample(x, y);
            const bool hidden =
                nearness * (1 + pen.lift) <= static_cast<double>(least_near(x, y, pen.reach));
            const auto opacity =
                static_cast<float>(cover * (hidden ? pen.hidden_opacity : pen.opacity));
            if (opacity <= s.opacity) continue;
            s.opacity = opacity;
            s.ink = pen.colour;
        }
    }
}

Image Canvas::image(int channels) const {
    Image out(width_ / kSamples, height_ / kSamples, channels);
    parallel_for(0, out.height, 16, [&](std::int64_t first, std::int64_t end) {
        write_rows(static_cast<int>(first), static_cast<int>(end), out);
    });
    return out;
}

void Canvas::write_rows(int first, int end, Image& picture) const {
    constexpr int all = kSamples * kSamples;
    const int channels = picture.channels;
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
    for (int r = first; r < end; ++r)
        for (int c = 0; c < picture.width; ++c) average(r, c, picture.pixel(top_ + r, c));
}

}  // namespace relief::io::detail
