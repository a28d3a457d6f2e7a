#include <cmath>
#include <limits>
#include <numbers>

#include "relief/core/parallel.h"
#include "relief/io/picture.h"

namespace relief::io {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegree = std::numbers::pi / 180;
constexpr std::int64_t kGrain = 16;

/// Rise per metre towards east and north; NaN in holes.
struct Slope {
    double east = kNone;
    double north = kNone;

    [[nodiscard]] bool known() const { return std::isfinite(east) && std::isfinite(north); }
};

class Slopes {
  public:
    Slopes(Heights z, Mask mask, CellSize cell) : z_(z), mask_(mask), cell_(cell) {}

    [[nodiscard]] Slope at(std::int64_t r, std::int64_t c) const {
        const double middle = height(r, c);
        if (std::isnan(middle)) return {};
        const double nw = height(r - 1, c - 1), n = height(r - 1, c), ne = height(r - 1, c + 1);
        const double w = height(r, c - 1), e = height(r, c + 1);
        const double sw = height(r + 1, c - 1), s = height(r + 1, c), se = height(r + 1, c + 1);
        const Slope horn = {((ne + 2 * e + se) - (nw + 2 * w + sw)) / (8 * cell_.x),
                            ((nw + 2 * n + ne) - (sw + 2 * s + se)) / (8 * cell_.y)};
        if (horn.known()) return horn;
        return {difference(w, middle, e) / cell_.x, difference(s, middle, n) / cell_.y};
    }

  private:
    /// NaN for what is missing, so that it shows in any sum.
    [[nodiscard]] double height(std::int64_t r, std::int64_t c) const {
        if (r < 0 || c < 0 || r >= z_.rows || c >= z_.cols) return kNone;
        if (mask_.count() > 0 && mask_(r, c) == 0) return kNone;
        const double value = z_(r, c);
        return std::isfinite(value) ? value : kNone;
    }

    static double difference(double before, double middle, double after) {
        if (std::isnan(before)) return std::isnan(after) ? 0 : after - middle;
        return std::isnan(after) ? middle - before : (after - before) / 2;
    }

    Heights z_;
    Mask mask_;
    CellSize cell_;
};

/// Direction towards a light.
struct Ray {
    double east, north, up;
};

Ray ray(double azimuth, double altitude) {
    return {std::sin(azimuth * kDegree) * std::cos(altitude * kDegree),
            std::cos(azimuth * kDegree) * std::cos(altitude * kDegree),
            std::sin(altitude * kDegree)};
}

double brightness(const Slope& g, const Ray& light) {
    const double across = light.up - g.east * light.east - g.north * light.north;
    return std::max(0.0, across / std::sqrt(1 + g.east * g.east + g.north * g.north));
}

/// Four lights 45 degrees apart; sin^2 between aspect and light, which sums to 2 over them.
double brightness(const Slope& g, const std::array<Ray, 4>& lights) {
    const double steep2 = g.east * g.east + g.north * g.north;
    double sum = 0;
    for (const Ray& light : lights) {
        const double flat2 = light.east * light.east + light.north * light.north;
        const double cross = g.east * light.north - g.north * light.east;
        const double weight = steep2 * flat2 > 0 ? cross * cross / (steep2 * flat2) : 0.5;
        sum += weight * brightness(g, light);
    }
    return sum / 2;
}

}  // namespace

double auto_exaggeration(Heights z, Mask mask, CellSize cell) {
    const Slopes slopes(z, mask, cell);
    std::vector<double> sums(static_cast<std::size_t>(z.rows));
    std::vector<std::int64_t> counts(sums.size());
    parallel_for(0, z.rows, kGrain, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r) {
            double sum = 0;
            std::int64_t count = 0;
            for (std::int64_t c = 0; c < z.cols; ++c) {
                const Slope g = slopes.at(r, c);
                if (!g.known()) continue;
                sum += std::sqrt(g.east * g.east + g.north * g.north);
                ++count;
            }
            sums[static_cast<std::size_t>(r)] = sum;
            counts[static_cast<std::size_t>(r)] = count;
        }
    });
    double sum = 0;
    double count = 0;
    for (std::size_t r = 0; r < sums.size(); ++r) {
        sum += sums[r];
        count += static_cast<double>(counts[r]);
    }
    const double factor = 0.404 * count / sum;  // tan(22 degrees)
    return std::isfinite(factor) && factor > 0 ? factor : 1;
}

Grid<double> illumination(Heights z, Mask mask, CellSize cell, const LightOptions& light) {
    const double stretch = light.vertical_exaggeration > 0 ? light.vertical_exaggeration
                                                           : auto_exaggeration(z, mask, cell);
    const Slopes slopes(z, mask, cell);
    const Ray sun = ray(light.azimuth, light.altitude);
    std::array<Ray, 4> suns{};
    for (std::size_t k = 0; k < 4; ++k)
        suns[k] = ray(light.azimuth - 90 + 45 * static_cast<double>(k), light.altitude);
    Grid<double> out(z.rows, z.cols);
    parallel_for(0, z.rows, kGrain, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r) {
            for (std::int64_t c = 0; c < z.cols; ++c) {
                Slope g = slopes.at(r, c);
                g = {g.east * stretch, g.north * stretch};
                const double value =
                    light.multidirectional ? brightness(g, suns) : brightness(g, sun);
                out(r, c) = g.known() ? value : kNone;
            }
        }
    });
    return out;
}

}  // namespace relief::io
