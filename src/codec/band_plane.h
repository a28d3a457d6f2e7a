#pragma once

#include <algorithm>
#include <cstdint>

#include "relief/core/grid.h"

namespace relief::codec {

/// |q|, also of the least int32.
inline std::uint32_t magnitude_of(std::int32_t q) {
    const auto bits = static_cast<std::uint32_t>(q);
    return q < 0 ? 0U - bits : bits;
}

/// What contexts need of a band: magnitudes up to 65535 and signs -1, 0, 1; zero outside the box.
class BandPlane {
  public:
    static constexpr std::int64_t kMargin = 2;

    explicit BandPlane(const LatticeBox& box)
        : box_(box),
          magnitudes_(box.rows + 2 * kMargin, box.cols + 2 * kMargin, 0),
          signs_(box.rows + 2 * kMargin, box.cols + 2 * kMargin, 0) {}

    [[nodiscard]] const LatticeBox& box() const { return box_; }

    /// Element c, -kMargin <= c < cols + kMargin, belongs to lattice point (row, box().col0 + c).
    /// Any row.
    [[nodiscard]] const std::uint16_t* magnitudes(std::int64_t row) const {
        return magnitudes_.row(index(row)) + kMargin;
    }
    [[nodiscard]] const std::int8_t* signs(std::int64_t row) const {
        return signs_.row(index(row)) + kMargin;
    }

    /// For rows of the box only: those outside are shared and stay zero.
    std::uint16_t* magnitudes(std::int64_t row) { return magnitudes_.row(index(row)) + kMargin; }
    std::int8_t* signs(std::int64_t row) { return signs_.row(index(row)) + kMargin; }

    static void set(std::uint16_t& magnitude, std::int8_t& sign, std::int32_t q) {
        magnitude = static_cast<std::uint16_t>(std::min<std::uint32_t>(magnitude_of(q), 65535));
        sign = static_cast<std::int8_t>((q > 0) - (q < 0));
    }

    void set_all(GridView<const std::int32_t> values) {
        for (std::int64_t r = 0; r < box_.rows; ++r) {
            std::uint16_t* magnitude = magnitudes(box_.row0 + r);
            std::int8_t* sign = signs(box_.row0 + r);
            for (std::int64_t c = 0; c < box_.cols; ++c) set(magnitude[c], sign[c], values(r, c));
        }
    }

  private:
    [[nodiscard]] std::int64_t index(std::int64_t row) const {
        return std::clamp<std::int64_t>(row - box_.row0 + kMargin, 0, magnitudes_.rows() - 1);
    }

    LatticeBox box_;
    Grid<std::uint16_t> magnitudes_;
    Grid<std::int8_t> signs_;
};

}  // namespace relief::codec
