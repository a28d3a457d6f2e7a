#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "relief/codec/band_coder.h"

namespace relief::codec {

/// What contexts need of a band: magnitudes up to 65535 and signs, zero outside the box.
class BandPlane {
  public:
    static constexpr std::int64_t kMargin = 2;

    explicit BandPlane(const LatticeBox& box)
        : box_(box), sizes_(box.rows + 2 * kMargin, box.cols + 2 * kMargin, 0),
          signs_(box.rows + 2 * kMargin, box.cols + 2 * kMargin, 0) {}

    [[nodiscard]] const LatticeBox& box() const { return box_; }

    /// Element c of the result belongs to row `row` and column `c` of the lattice, box().col0 - kMargin <= c.
    /// Rows of the lattice outside the plane: a row of zeros.
    [[nodiscard]] const std::uint16_t* sizes(std::int64_t row) const { return sizes_.row(index(row)) + kMargin; }
    [[nodiscard]] const std::int8_t* signs(std::int64_t row) const { return signs_.row(index(row)) + kMargin; }
    std::uint16_t* sizes(std::int64_t row) { return sizes_.row(index(row)) + kMargin; }
    std::int8_t* signs(std::int64_t row) { return signs_.row(index(row)) + kMargin; }

    void set_row(std::int64_t row, const std::int32_t* values) {
        std::uint16_t* size = sizes(row);
        std::int8_t* sign = signs(row);
        for (std::int64_t c = 0; c < box_.cols; ++c) {
            const std::int32_t q = values[c];
            const std::uint32_t magnitude = q < 0 ? 0U - static_cast<std::uint32_t>(q) : static_cast<std::uint32_t>(q);
            size[c] = static_cast<std::uint16_t>(std::min<std::uint32_t>(magnitude, 65535));
            sign[c] = static_cast<std::int8_t>((q > 0) - (q < 0));
        }
    }

  private:
    /// Rows beyond the margin read as the margin's outermost row, which stays zero.
    [[nodiscard]] std::int64_t index(std::int64_t row) const {
        return std::clamp<std::int64_t>(row - box_.row0 + kMargin, 0, sizes_.rows() - 1);
    }

    LatticeBox box_;
    Grid<std::uint16_t> sizes_;
    Grid<std::int8_t> signs_;
};

}  // namespace relief::codec
