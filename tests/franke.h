#pragma once

#include <cmath>

namespace relief::test {

/// A function of the unit square with its gradient; x along columns, y down the rows.
struct Gradient {
    double value = 0;
    double x = 0;
    double y = 0;
};

/// Franke's function: four Gaussian bumps, the usual test of surface fitting.
inline Gradient franke(double x, double y) {
    Gradient sum;
    // weight exp(-((9x - p)^2 / u) - ((9y - q)^2 / v)); the second is linear in 9y + 1.
    const auto add = [&](double weight, double exponent, double ex, double ey) {
        const double value = weight * std::exp(exponent);
        sum.value += value;
        sum.x += value * ex;
        sum.y += value * ey;
    };
    const double u = 9 * x, v = 9 * y;
    add(0.75, -((u - 2) * (u - 2) + (v - 2) * (v - 2)) / 4, -4.5 * (u - 2), -4.5 * (v - 2));
    add(0.75, -(u + 1) * (u + 1) / 49 - (v + 1) / 10, -18 * (u + 1) / 49, -0.9);
    add(0.5, -((u - 7) * (u - 7) + (v - 3) * (v - 3)) / 4, -4.5 * (u - 7), -4.5 * (v - 3));
    add(-0.2, -(u - 4) * (u - 4) - (v - 7) * (v - 7), -18 * (u - 4), -18 * (v - 7));
    return sum;
}

/// exp(-R / (R - rho^2)) within the distance sqrt(R) = 1 / sqrt(128) of the centre, else zero.
inline Gradient small_bump(double x, double y) {
    constexpr double radius = 1 / 128.0;
    const double dx = x - 0.5, dy = y - 0.5;
    const double rest = radius - (dx * dx + dy * dy);
    if (rest <= 0) return {};
    const double value = std::exp(-radius / rest);
    const double slope = -2 * radius * value / (rest * rest);
    return {value, slope * dx, slope * dy};
}

}  // namespace relief::test
