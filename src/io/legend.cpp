#include "io/legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "io/font.h"

namespace relief::io::detail {

double round_scale(double x) {
    if (!(x > 0)) return 1;
    const double decade = std::pow(10, std::floor(std::log10(x)));
    for (const double digit : {1.0, 2.0, 5.0})
        if (digit * decade >= x) return digit * decade;
    return 10 * decade;
}

Image with_legend(const Image& picture, const Legend& legend) {
    const int dot = std::max(1, picture.width / 400);
    const int width = std::max(picture.width, 180);
    const int margin = 6 * dot;
    const int bar = 10 * dot;
    Image out(width, picture.height + 3 * margin + bar + 9 * dot, picture.channels);
    std::fill(out.pixels.begin(), out.pixels.end(), std::uint8_t{255});
    for (int r = 0; r < picture.height; ++r)
        std::copy_n(picture.pixel(r, 0), picture.width * picture.channels,
                    out.pixel(r, (width - picture.width) / 2));

    const int length = std::min(width - 60 * dot, 300 * dot);
    const int left = (width - length) / 2;
    const int top = picture.height + margin;
    const double low = legend.from_zero ? 0 : -1;
    for (int r = 0; r < bar; ++r)
        for (int c = 0; c < length; ++c) {
            const Srgb rgb = srgb_of(difference_light(low + (1 - low) * (c + 0.5) / length));
            std::copy(rgb.begin(), rgb.end(), out.pixel(top + r, left + c));
        }
    for (const double part : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
        if (part < low) continue;
        const int at =
            left + static_cast<int>(std::lround((part - low) / (1 - low) * (length - dot)));
        for (int r = 0; r < 3 * dot; ++r)
            for (int c = 0; c < dot; ++c)
                std::copy(kInk.begin(), kInk.end(), out.pixel(top + bar + r, at + c));
        const double value = part * legend.scale;
        std::string label = part == 0          ? "0"
                            : legend.from_zero ? fmt::format("{:.3g}", value)
                                               : fmt::format("{:+.3g}", value);
        if (part == 1 && !legend.unit.empty()) label += " " + legend.unit;
        draw_text(out, label, top + bar + 5 * dot, at - text_width(label, dot) / 2, dot, kInk);
    }
    return out;
}

}  // namespace relief::io::detail
