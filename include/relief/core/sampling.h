#pragma once

#include <array>
#include <cstdint>

#include "relief/core/raster.h"

/// Where the samples of one raster lie among those of another, and on the ground.
namespace relief {

/// Places first + k step, k < count, along one side of a raster, in its samples: cells of `step`
/// samples around them.
struct SampleAxis {
    double first = 0;
    double step = 1;
    std::int64_t count = 0;

    /// The centres of `cells` equal cells that cover `length` of these cells, from the border of
    /// cell `begin` on.
    [[nodiscard]] SampleAxis cut(double begin, double length, std::int64_t cells) const {
        const double ratio = length / static_cast<double>(cells);
        return {first + step * (begin + 0.5 * (ratio - 1)), step * ratio, cells};
    }
    friend bool operator==(const SampleAxis&, const SampleAxis&) = default;
};

/// A grid of places.
struct Sampling {
    SampleAxis rows;
    SampleAxis cols;

    friend bool operator==(const Sampling&, const Sampling&) = default;
};

/// Where a raster of such samples of a raster lies.
[[nodiscard]] GeoReference georeference_of(GeoReference geo, const Sampling& sampling);

/// From places in the coordinates of a georeference to samples: of (x, y) come row and column.
class PlaceMap {
  public:
    /// Without a transform x is the column and y the row. Errors: BadInput for a transform that
    /// gives different samples the same place.
    [[nodiscard]] static Result<PlaceMap> create(const GeoReference& geo);

    [[nodiscard]] double row(double x, double y) const { return ix_ * (x - x0_) + iy_ * (y - y0_); }
    [[nodiscard]] double col(double x, double y) const { return jx_ * (x - x0_) + jy_ * (y - y0_); }

    /// d/dx and d/dy of what changes by di a row and by dj a column.
    [[nodiscard]] std::array<double, 2> gradient(double di, double dj) const {
        return {dj * jx_ + di * ix_, dj * jy_ + di * iy_};
    }
    /// d2/dx2, d2/dxdy and d2/dy2.
    [[nodiscard]] std::array<double, 3> hessian(double dii, double dij, double djj) const {
        return {djj * jx_ * jx_ + 2 * dij * jx_ * ix_ + dii * ix_ * ix_,
                djj * jx_ * jy_ + dij * (jx_ * iy_ + jy_ * ix_) + dii * ix_ * iy_,
                djj * jy_ * jy_ + 2 * dij * jy_ * iy_ + dii * iy_ * iy_};
    }

  private:
    double x0_ = 0, y0_ = 0;  ///< place of sample (0, 0)
    double jx_ = 1, jy_ = 0;  ///< of columns along x and y
    double ix_ = 0, iy_ = 1;  ///< of rows
};

}  // namespace relief
