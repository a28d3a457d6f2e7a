#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>

#include "relief/core/grid.h"

namespace relief::codec {

template <class Draw>
void fill(Grid<std::int32_t>& grid, Draw draw) {
    for (std::int64_t r = 0; r < grid.rows(); ++r)
        for (std::int64_t c = 0; c < grid.cols(); ++c) grid(r, c) = draw();
}

/// Independent values with P(|q| = m) = (1 - theta) theta^m and random signs; the same on every
/// machine.
class GeometricSource {
  public:
    GeometricSource(double theta, std::uint32_t seed) : theta_(theta), engine_(seed) {}

    std::int32_t operator()() {
        std::int32_t magnitude = 0;
        while (uniform() < theta_) ++magnitude;
        return uniform() < 0.5 ? -magnitude : magnitude;
    }

    /// What the best code for the source spends on a value.
    [[nodiscard]] double bits(std::int32_t q) const {
        return -std::log2(1 - theta_) - std::abs(q) * std::log2(theta_) + (q != 0 ? 1 : 0);
    }

  private:
    double uniform() { return engine_() / 4294967296.0; }

    double theta_;
    std::mt19937 engine_;
};

}  // namespace relief::codec
