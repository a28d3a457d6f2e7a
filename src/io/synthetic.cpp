#include "relief/io/synthetic.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "relief/core/parallel.h"

namespace relief::io {

namespace {

constexpr int kSmallest = 2;
constexpr int kLargest = 65536;
constexpr double kHole = std::numeric_limits<double>::quiet_NaN();

/// An n x n raster whose samples are the points with spacing `step`, the first centred at (0, (n -
/// 1) step).
Raster blank(std::int64_t rows, std::int64_t cols, std::size_t planes, double step) {
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    raster.type = SampleType::Float32;
    for (std::size_t p = 0; p < planes; ++p) raster.planes.emplace_back(rows, cols);
    const double top = (static_cast<double>(rows) - 0.5) * step;
    raster.geo.transform = {-step / 2, step, 0, top, 0, -step};
    raster.geo.pixel_is_point = true;
    raster.unit = std::string("m");
    return raster;
}

/// Sets every sample of a plane to value(row, col), rounded to float32.
template <class Value>
void fill(Grid<double>& plane, Value value) {
    parallel_for(0, plane.rows(), 8, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r)
            for (std::int64_t c = 0; c < plane.cols(); ++c)
                plane(r, c) = static_cast<double>(static_cast<float>(value(r, c)));
    });
}

/// z = f(x, y) at n x n points of [0, 1]^2.
template <class Function>
Raster on_unit_square(int n, Function f) {
    n = std::clamp(n, kSmallest, kLargest);
    const double step = 1.0 / (n - 1);
    Raster raster = blank(n, n, 1, step);
    fill(raster.planes[0], [&](std::int64_t r, std::int64_t c) {
        return f(static_cast<double>(c) / (n - 1), static_cast<double>(n - 1 - r) / (n - 1));
    });
    return raster;
}

double square(double t) {
    return t * t;
}

std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
    std::uint32_t h = x * 0x9E3779B1U + (y ^ seed * 0x85EBCA77U) * 0xC2B2AE3DU;
    for (int round = 0; round < 2; ++round) {
        h ^= h >> 15;
        h *= 0x2C1B3C6DU;
        h ^= h >> 12;
        h *= 0x297A2D39U;
    }
    return h ^ h >> 15;
}

double fade(double t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}
double mix(double a, double b, double t) {
    return a + t * (b - a);
}

/// Gradient noise with 16 directions, about -1 .. 1, smooth to the second derivative.
double noise(double x, double y, std::uint32_t seed) {
    // Points of a circle of radius 1.5, close enough: the sixteen sums of the multiples of 1/8 need
    // no sine.
    static constexpr std::array<std::array<double, 2>, 16> kGradients = {{{1.5, 0},
                                                                          {1.375, 0.5625},
                                                                          {1.0625, 1.0625},
                                                                          {0.5625, 1.375},
                                                                          {0, 1.5},
                                                                          {-0.5625, 1.375},
                                                                          {-1.0625, 1.0625},
                                                                          {-1.375, 0.5625},
                                                                          {-1.5, 0},
                                                                          {-1.375, -0.5625},
                                                                          {-1.0625, -1.0625},
                                                                          {-0.5625, -1.375},
                                                                          {0, -1.5},
                                                                          {0.5625, -1.375},
                                                                          {1.0625, -1.0625},
                                                                          {1.375, -0.5625}}};
    const double x0 = std::floor(x);
    const double y0 = std::floor(y);
    const double u = x - x0;
    const double v = y - y0;
    const auto i = static_cast<std::uint32_t>(static_cast<std::int64_t>(x0));
    const auto j = static_cast<std::uint32_t>(static_cast<std::int64_t>(y0));
    const auto corner = [&](std::uint32_t a, std::uint32_t b) {
        const auto& g = kGradients[hash(i + a, j + b, seed) >> 28];
        return g[0] * (u - a) + g[1] * (v - b);
    };
    return mix(mix(corner(0, 0), corner(1, 0), fade(u)), mix(corner(0, 1), corner(1, 1), fade(u)),
               fade(v));
}

/// Height in metres at (x, y), in units of the broadest ranges.
double mountain(double x, double y, std::uint32_t seed) {
    constexpr int octaves = 10;
    // Bent ground: ridges meander instead of following the lattice.
    const double bent_x = x + 0.22 * noise(1.3 * x, 1.3 * y, seed ^ 0x51U);
    const double bent_y = y + 0.22 * noise(1.3 * x, 1.3 * y, seed ^ 0x52U);
    double frequency = 1;
    double amplitude = 1;
    double weight = 1;
    double sum = 0;
    for (std::uint32_t k = 0; k < octaves; ++k) {
        const double n = noise(bent_x * frequency, bent_y * frequency, seed + 101 * k);
        const double crest = 1 - std::min(1.0, 1.35 * std::abs(n));
        const double signal = crest * crest * weight;
        sum += signal * amplitude;
        weight = std::min(1.0, 0.15 + 1.9 * signal);  // rough where high, smoother in the valleys
        frequency *= 2.07;
        amplitude *= 0.47;
    }
    const double broad = 0.5 + 0.5 * noise(0.37 * x + 5.3, 0.37 * y - 2.9, seed ^ 0x60U);
    return 1100 * sum * (0.45 + 0.75 * broad);
}

/// A feature of the face: a Gaussian hill or hollow; metres from the middle of the face, y up.
struct Feature {
    double x, y, width, height, depth;
};

constexpr Feature kFeatures[] = {
    {0, -0.012, 0.0085, 0.012, 0.021},      // tip of the nose
    {0, 0.010, 0.0065, 0.016, 0.011},       // bridge
    {0.0115, -0.017, 0.006, 0.006, 0.008},  // wings
    {-0.0115, -0.017, 0.006, 0.006, 0.008}, {0.0300, 0.022, 0.014, 0.009, -0.016},  // eye sockets
    {-0.0300, 0.022, 0.014, 0.009, -0.016}, {0.0300, 0.020, 0.009, 0.0065, 0.011},  // eyes
    {-0.0300, 0.020, 0.009, 0.0065, 0.011}, {0.0280, 0.038, 0.017, 0.006, 0.006},   // brows
    {-0.0280, 0.038, 0.017, 0.006, 0.006},  {0.0400, -0.008, 0.016, 0.016, 0.006},  // cheeks
    {-0.0400, -0.008, 0.016, 0.016, 0.006}, {0, -0.0390, 0.016, 0.0038, 0.0075},    // upper lip
    {0, -0.0445, 0.018, 0.0018, -0.004},                                            // mouth
    {0, -0.0500, 0.013, 0.0042, 0.008},                                             // lower lip
    {0, -0.0600, 0.014, 0.005, -0.004},                                             // below it
    {0, -0.0780, 0.016, 0.011, 0.012},                                              // chin
};

/// Depth towards the camera at (x, y), or a hole beside the head.
double face_depth(double x, double y) {
    const double rest = 1 - square(x / 0.080) - square(y / 0.118);
    if (rest < 0.06) return kHole;
    double depth = 0.085 * std::sqrt(rest);
    for (const Feature& f : kFeatures)
        depth +=
            f.depth * std::exp(-(square((x - f.x) / f.width) + square((y - f.y) / f.height)) / 2);
    return depth;
}

}  // namespace

Raster franke(int n) {
    return on_unit_square(n, [](double x, double y) {
        const double u = 9 * x;
        const double v = 9 * y;
        return 0.75 * std::exp(-(square(u - 2) + square(v - 2)) / 4) +
               0.75 * std::exp(-square(u + 1) / 49 - (v + 1) / 10) +
               0.5 * std::exp(-(square(u - 7) + square(v - 3)) / 4) -
               0.2 * std::exp(-square(u - 4) - square(v - 7));
    });
}

Raster bump(int n) {
    return on_unit_square(n, [](double x, double y) {
        constexpr double radius2 = 1.0 / 128;
        const double rho2 = square(x - 0.5) + square(y - 0.5);
        return rho2 < radius2 ? std::exp(-radius2 / (radius2 - rho2)) : 0.0;
    });
}

Raster ridged(int n, std::uint32_t seed) {
    n = std::clamp(n, kSmallest, kLargest);
    constexpr double step = 30;
    constexpr double unit = 6500;
    Raster raster = blank(n, n, 1, step);
    fill(raster.planes[0], [&](std::int64_t r, std::int64_t c) {
        return mountain(static_cast<double>(c) * step / unit, static_cast<double>(r) * step / unit,
                        seed);
    });
    return raster;
}

Raster torus(int n) {
    n = std::clamp(n, kSmallest, kLargest / 2);
    Raster raster = blank(n, 2 * n, 3, 1);
    raster.geo = {};  // x and y are samples here
    raster.band_names = {"x", "y", "z"};
    constexpr double tube = 0.4;
    const auto angles = [&](std::int64_t r, std::int64_t c) {
        const double turn = 2 * std::numbers::pi;
        return std::pair(turn * static_cast<double>(r) / (n - 1),
                         turn * static_cast<double>(c) / (2 * n - 1));
    };
    fill(raster.planes[0], [&](std::int64_t r, std::int64_t c) {
        const auto [around, along] = angles(r, c);
        return (1 + tube * std::cos(around)) * std::cos(along);
    });
    fill(raster.planes[1], [&](std::int64_t r, std::int64_t c) {
        const auto [around, along] = angles(r, c);
        return (1 + tube * std::cos(around)) * std::sin(along);
    });
    fill(raster.planes[2],
         [&](std::int64_t r, std::int64_t c) { return tube * std::sin(angles(r, c).first); });
    return raster;
}

Raster face(int n) {
    n = std::clamp(n, kSmallest, kLargest);
    constexpr double width = 0.26;
    const double step = width / (n - 1);
    Raster raster = blank(n, n, 1, step);
    fill(raster.planes[0], [&](std::int64_t r, std::int64_t c) {
        return face_depth(static_cast<double>(c) * step - width / 2,
                          width / 2 - static_cast<double>(r) * step);
    });
    raster.mask = Grid<std::uint8_t>(n, n);
    for (std::int64_t r = 0; r < n; ++r)
        for (std::int64_t c = 0; c < n; ++c)
            raster.mask(r, c) = std::isnan(raster.planes[0](r, c)) ? 0 : 1;
    return raster;
}

std::vector<std::string_view> synthetic_names() {
    return {"franke", "bump", "ridged", "torus", "face"};
}

Result<Raster> synthetic(std::string_view name, const SyntheticOptions& options) {
    if (options.size < kSmallest || options.size > kLargest)
        return Error{ErrorCode::InvalidArgument,
                     fmt::format("size {} is not in {} .. {}", options.size, kSmallest, kLargest),
                     {}};
    if (name == "franke") return franke(options.size);
    if (name == "bump") return bump(options.size);
    if (name == "ridged") return ridged(options.size, options.seed);
    if (name == "torus") return torus(options.size);
    if (name == "face") return face(options.size);
    return Error{
        ErrorCode::InvalidArgument,
        fmt::format("no surface '{}'; choose one of {}", name, fmt::join(synthetic_names(), ", ")),
        {}};
}

}  // namespace relief::io
