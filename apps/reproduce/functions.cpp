#include "functions.h"

#include <cmath>

namespace relief::reproduce {

using spline::PlaneJet;

namespace {

/// amplitude exp(-a (x - x0)^2 - b (y - y0)^2).
PlaneJet hill(Vec2 p, double amplitude, double a, double x0, double b, double y0) {
    const double dx = p.x - x0;
    const double dy = p.y - y0;
    const double value = amplitude * std::exp(-a * dx * dx - b * dy * dy);
    return {value, {-2 * a * dx * value, -2 * b * dy * value}};
}

}  // namespace

PlaneJet franke(Vec2 p) {
    const double decay = std::exp(-(9 * p.y + 1) / 10);
    const PlaneJet ridge = hill(p, 0.75, 81.0 / 49, -1.0 / 9, 0, 0);
    PlaneJet sum{ridge.value * decay, {ridge.gradient.x * decay, -0.9 * ridge.value * decay}};
    for (const PlaneJet& term : {hill(p, 0.75, 81.0 / 4, 2.0 / 9, 81.0 / 4, 2.0 / 9),
                                 hill(p, 0.5, 81.0 / 4, 7.0 / 9, 81.0 / 4, 1.0 / 3),
                                 hill(p, -0.2, 81, 4.0 / 9, 81, 7.0 / 9)}) {
        sum.value += term.value;
        sum.gradient = sum.gradient + term.gradient;
    }
    return sum;
}

}  // namespace relief::reproduce
