#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

#include "relief/codec/band_coder.h"

namespace relief::codec {

/// The bands of a level with their values.
struct Level {
    std::vector<Grid<std::int32_t>> grids;
    std::vector<BandView> bands;

    /// A band of zeros; returns its values.
    Grid<std::int32_t>& add(const LatticeBox& box, bool predict = false) {
        Grid<std::int32_t>& grid = grids.emplace_back(box.rows, box.cols, 0);
        bands.push_back({box, grid.view(), predict});
        return grid;
    }

    /// The same boxes, filled with something else.
    [[nodiscard]] Level blank() const {
        Level other;
        for (const BandView& band : bands) {
            Grid<std::int32_t>& grid = other.add(band.box, band.predict);
            for (std::int64_t r = 0; r < grid.rows(); ++r)
                std::fill_n(grid.row(r), grid.cols(), -12345);
        }
        return other;
    }

    friend bool operator==(const Level& a, const Level& b) {
        for (std::size_t k = 0; k < a.grids.size(); ++k)
            for (std::int64_t r = 0; r < a.grids[k].rows(); ++r)
                if (!std::equal(a.grids[k].row(r), a.grids[k].row(r) + a.grids[k].cols(),
                                b.grids[k].row(r)))
                    return false;
        return true;
    }
};

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
