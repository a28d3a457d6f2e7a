#include "relief/io/picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/colour.h"
#include "io/font.h"
#include "io/legend.h"
#include "relief/core/parallel.h"

namespace relief::io {

namespace {

using detail::Srgb;

constexpr Srgb kHoleGrey = {214, 214, 214};

bool is_valid(Mask mask, std::int64_t r, std::int64_t c) {
    return mask.count() == 0 || mask(r, c) != 0;
}

/// An image of one pixel a sample; colour(row, col) is asked where valid(row, col).
template <class Valid, class Colour>
Image paint(Heights z, HoleStyle holes, Valid valid, Colour colour) {
    Image image(static_cast<int>(z.cols), static_cast<int>(z.rows),
                holes == HoleStyle::Grey ? 3 : 4);
    parallel_for(0, z.rows, 16, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r) {
            for (std::int64_t c = 0; c < z.cols; ++c) {
                const bool there = valid(r, c);
                const Srgb rgb = there ? colour(r, c) : kHoleGrey;
                std::uint8_t* p = image.pixel(static_cast<int>(r), static_cast<int>(c));
                std::copy(rgb.begin(), rgb.end(), p);
                if (image.channels == 4) p[3] = there ? 255 : 0;
            }
        }
    });
    return image;
}

/// The picture at the width asked for, in the proportions of the ground.
Image laid_out(Image image, CellSize cell, int width) {
    if (width <= 0 || image.width < 1 || image.height < 1) return image;
    const double proportion = image.height * cell.y / (image.width * cell.x);
    return resize(image, width, std::max(1, static_cast<int>(std::lround(width * proportion))));
}

struct Range {
    double low = 0;
    double high = 0;
};

/// Smallest and largest value(row, col) where valid(row, col); {0, 0} if there is none.
template <class Valid, class Value>
Range range_of(Heights z, Valid valid, Value value) {
    bool any = false;
    Range range;
    for (std::int64_t r = 0; r < z.rows; ++r) {
        for (std::int64_t c = 0; c < z.cols; ++c) {
            if (!valid(r, c)) continue;
            const double v = value(r, c);
            range = any ? Range{std::min(range.low, v), std::max(range.high, v)} : Range{v, v};
            any = true;
        }
    }
    return range;
}

/// Where a height lies on the ramp.
double on_ramp(double z, const Range& range) {
    if (range.low < 0 && range.high > 0) return z < 0 ? -z / range.low : z / range.high;
    return range.high > range.low ? (z - range.low) / (range.high - range.low) : 0.5;
}

}  // namespace

Image hillshade(Heights z, Mask mask, CellSize cell, const PictureOptions& options) {
    const Grid<double> light = illumination(z, mask, cell, options.light);
    const auto valid = [&](std::int64_t r, std::int64_t c) { return !std::isnan(light(r, c)); };
    const auto grey = [&](std::int64_t r, std::int64_t c) {
        const auto code =
            static_cast<std::uint8_t>(std::lround(24 + 228 * std::min(1.0, light(r, c))));
        return Srgb{code, code, code};
    };
    return laid_out(paint(z, options.holes, valid, grey), cell, options.width);
}

Image colour_by_height(Heights z, Mask mask, CellSize cell, const PictureOptions& options,
                       Shading shading) {
    const auto valid = [&](std::int64_t r, std::int64_t c) {
        return is_valid(mask, r, c) && std::isfinite(z(r, c));
    };
    const Range range = range_of(z, valid, [&](std::int64_t r, std::int64_t c) { return z(r, c); });
    const auto base = [&](std::int64_t r, std::int64_t c) -> const detail::Light& {
        return detail::height_light(on_ramp(z(r, c), range));
    };
    Image image;
    if (shading == Shading::Flat) {
        image = paint(z, options.holes, valid,
                      [&](std::int64_t r, std::int64_t c) { return detail::srgb_of(base(r, c)); });
    } else {
        const Grid<double> light = illumination(z, mask, cell, options.light);
        const double level = std::sin(options.light.altitude * std::numbers::pi / 180);
        image = paint(z, options.holes, valid, [&](std::int64_t r, std::int64_t c) {
            return detail::srgb_of(detail::lit(base(r, c), light(r, c), level));
        });
    }
    return laid_out(std::move(image), cell, options.width);
}

Image drape(Heights z, Mask mask, CellSize cell, const Image& image,
            const PictureOptions& options) {
    const Image stretched = resize(image, static_cast<int>(z.cols), static_cast<int>(z.rows));
    const Grid<double> light = illumination(z, mask, cell, options.light);
    const double level = std::sin(options.light.altitude * std::numbers::pi / 180);
    const auto valid = [&](std::int64_t r, std::int64_t c) { return !std::isnan(light(r, c)); };
    const auto colour = [&](std::int64_t r, std::int64_t c) {
        const std::uint8_t* pixel = stretched.pixel(static_cast<int>(r), static_cast<int>(c));
        return detail::srgb_of(
            detail::lit(detail::light_of({pixel[0], pixel[1], pixel[2]}), light(r, c), level));
    };
    return laid_out(paint(z, options.holes, valid, colour), cell, options.width);
}

Image with_caption(const Image& picture, std::string_view text) {
    const int columns = std::max(1, detail::text_width(text, 1));
    const int dot = std::clamp(picture.width * 3 / 4 / columns, 1, 3);
    const int margin = 4 * dot;
    Image out(picture.width, picture.height + 7 * dot + 2 * margin, picture.channels);
    std::fill(out.pixels.begin(), out.pixels.end(), std::uint8_t{255});
    std::copy(picture.pixels.begin(), picture.pixels.end(), out.pixels.begin());
    const int left = (picture.width - detail::text_width(text, dot)) / 2;
    detail::draw_text(out, text, picture.height + margin, left, dot, detail::kInk);
    return out;
}

Image error_map(Heights surface, Heights reference, Mask mask, CellSize cell,
                const ErrorMapOptions& options) {
    const auto error = [&](std::int64_t r, std::int64_t c) {
        return surface(r, c) - reference(r, c);
    };
    const auto valid = [&](std::int64_t r, std::int64_t c) {
        return is_valid(mask, r, c) && std::isfinite(error(r, c));
    };
    double scale = options.scale;
    if (!(scale > 0)) {
        const Range range = range_of(surface, valid, error);
        const double largest = std::max(-range.low, range.high);
        scale = detail::round_scale(largest);
    }
    Image image = paint(surface, options.picture.holes, valid, [&](std::int64_t r, std::int64_t c) {
        return difference_colour(error(r, c) / scale);
    });
    return detail::with_legend(laid_out(std::move(image), cell, options.picture.width),
                               {.scale = scale, .unit = options.unit});
}

}  // namespace relief::io
