#pragma once

#include "relief/codec/raster_codec.h"
#include "relief/core/stream.h"

/// Where the finest lattice of the closed loop begins. Grids that were interpolated from coarser
/// ones are coded best if the samples of the coarser grid are those of level 1.
namespace relief::codec {

/// A margin where the samples with even index, along an axis, are much more often the mean of their
/// two neighbours than those with odd index; else none. Reads 128 rows at most. Errors: of the
/// source.
[[nodiscard]] Result<LatticeMargin> choose_margin(const RasterSource& source);

/// A raster with a margin in front: copies of its first row and column. The source must outlive it.
class RasterWithMargin final : public RasterSource {
  public:
    RasterWithMargin(const RasterSource& source, LatticeMargin margin);
    [[nodiscard]] const Raster& description() const override { return description_; }
    [[nodiscard]] int components() const override { return source_.components(); }
    [[nodiscard]] Result<Raster> read(const LatticeBox& window) const override;
    [[nodiscard]] Result<RasterView> view(const LatticeBox& window, Raster& room) const override;

  private:
    const RasterSource& source_;
    LatticeMargin margin_;
    Raster description_;
};

}  // namespace relief::codec
