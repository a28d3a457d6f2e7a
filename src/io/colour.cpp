#include "io/colour.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "relief/io/picture.h"

namespace relief::io::detail {

namespace {

struct Oklab {
    double lightness, a, b;
};

Light light_from(const Oklab& c) {
    const auto cube = [](double t) { return t * t * t; };
    const double l = cube(c.lightness + 0.3963377774 * c.a + 0.2158037573 * c.b);
    const double m = cube(c.lightness - 0.1055613458 * c.a - 0.0638541728 * c.b);
    const double s = cube(c.lightness - 0.0894841775 * c.a - 1.2914855480 * c.b);
    const Light rgb = {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                       -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                       -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
    return {std::clamp(rgb[0], 0.0, 1.0), std::clamp(rgb[1], 0.0, 1.0),
            std::clamp(rgb[2], 0.0, 1.0)};
}

double encode(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double decode(double code) {
    return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

/// Evenly spaced anchors joined by a Catmull-Rom curve; t in 0 .. 1.
template <std::size_t N>
Oklab along(const std::array<Oklab, N>& anchors, double t) {
    const double position = t * (N - 1);
    const auto k =
        std::min(static_cast<std::ptrdiff_t>(position), static_cast<std::ptrdiff_t>(N) - 2);
    const double u = position - static_cast<double>(k);
    const auto at = [&](std::ptrdiff_t i) {
        return anchors[static_cast<std::size_t>(
            std::clamp<std::ptrdiff_t>(i, 0, static_cast<std::ptrdiff_t>(N) - 1))];
    };
    const std::array<double, 4> w = {((2 - u) * u - 1) * u / 2, ((3 * u - 5) * u * u + 2) / 2,
                                     ((4 - 3 * u) * u + 1) * u / 2, (u - 1) * u * u / 2};
    Oklab sum{0, 0, 0};
    for (std::ptrdiff_t i = 0; i < 4; ++i) {
        const Oklab c = at(k + i - 1);
        const double weight = w[static_cast<std::size_t>(i)];
        sum = {0, sum.a + weight * c.a, sum.b + weight * c.b};
    }
    // Lightness stays linear, so that equal steps of height are equal steps of lightness.
    sum.lightness =
        anchors.front().lightness + t * (anchors.back().lightness - anchors.front().lightness);
    return sum;
}

// The anchors' middle lightnesses follow from the ends.
constexpr std::array<Oklab, 5> kLand = {{{0.54, -0.066, 0.040},
                                         {0, -0.046, 0.066},
                                         {0, 0.000, 0.082},
                                         {0, 0.022, 0.052},
                                         {0.975, 0.001, 0.008}}};
constexpr std::array<Oklab, 3> kSea = {
    {{0.30, -0.010, -0.078}, {0, -0.042, -0.088}, {0.86, -0.044, -0.034}}};
constexpr Oklab kBlue = {0.42, -0.034, -0.126};
constexpr Oklab kRed = {0.42, 0.135, 0.078};
constexpr Oklab kNeutral = {0.97, 0, 0};

constexpr std::size_t kArm = 1024;
using Ramp = std::array<Light, 2 * kArm + 1>;

template <class Colour>
Ramp tabulate(Colour colour) {
    Ramp ramp;
    for (std::size_t k = 0; k < ramp.size(); ++k)
        ramp[k] = light_from(colour(static_cast<double>(k) / kArm - 1));
    return ramp;
}

const Light& look_up(const Ramp& ramp, double t) {
    return ramp[static_cast<std::size_t>(std::lround((std::clamp(t, -1.0, 1.0) + 1) * kArm))];
}

}  // namespace

double linear_of(std::uint8_t code) {
    static const std::array<double, 256> table = [] {
        std::array<double, 256> t{};
        for (std::size_t k = 0; k < 256; ++k) t[k] = decode(static_cast<double>(k) / 255);
        return t;
    }();
    return table[code];
}

std::uint8_t code_of(double linear) {
    static const std::array<std::uint8_t, 65536> table = [] {
        std::array<std::uint8_t, 65536> t{};
        for (std::size_t k = 0; k < t.size(); ++k)
            t[k] = static_cast<std::uint8_t>(
                std::lround(255 * encode(static_cast<double>(k) / 65535)));
        return t;
    }();
    return table[static_cast<std::size_t>(std::lround(std::clamp(linear, 0.0, 1.0) * 65535))];
}

const Light& height_light(double height) {
    static const Ramp ramp =
        tabulate([](double t) { return t < 0 ? along(kSea, t + 1) : along(kLand, t); });
    return look_up(ramp, height);
}

const Light& difference_light(double difference) {
    static const Ramp ramp = tabulate([](double t) {
        const Oklab& end = t < 0 ? kBlue : kRed;
        const double s = std::abs(t);
        return Oklab{kNeutral.lightness + s * (end.lightness - kNeutral.lightness), s * end.a,
                     s * end.b};
    });
    return look_up(ramp, difference);
}

Light lit(const Light& c, double brightness, double level) {
    constexpr Light sky = {0.27, 0.31, 0.40};
    const double sun = brightness / level;
    Light out;
    for (std::size_t k = 0; k < 3; ++k) out[k] = c[k] * (sky[k] + (1 - sky[k]) * sun);
    return out;
}

}  // namespace relief::io::detail

namespace relief::io {

std::array<std::uint8_t, 3> height_colour(double height) {
    return detail::srgb_of(detail::height_light(height));
}

std::array<std::uint8_t, 3> difference_colour(double difference) {
    return detail::srgb_of(detail::difference_light(difference));
}

}  // namespace relief::io
