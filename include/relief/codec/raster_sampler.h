#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "relief/codec/raster_surface.h"
#include "relief/core/sampling.h"

/// Rasters of a raster file's surface at any sampling: values, slopes, shades.
namespace relief::codec {

/// What a raster shows of a surface.
enum class Quantity : std::uint8_t {
    Value,
    Dx,         ///< change of the value per unit of x
    Dy,         ///< and of y
    Slope,      ///< degrees from the level, 0 .. 90
    Aspect,     ///< degrees from north, clockwise, that the slope faces; a hole where it is level
    Hillshade,  ///< 1 (dark) .. 255 of a matt surface in light from the north-west, 45 degrees high
};

/// "value", "dx", "dy", "slope", "aspect", "hillshade".
[[nodiscard]] std::string_view quantity_name(Quantity quantity);
/// Errors: InvalidArgument listing the names.
[[nodiscard]] Result<Quantity> quantity_from_name(std::string_view name);

/// Samples a raster file at places that need not be its samples. Where parts of the file can not be
/// decoded alone, the last level is kept as a whole. Not for several threads at once.
class RasterSampler {
  public:
    /// The file must outlive this and keep its address.
    explicit RasterSampler(const RasterFile& file) : file_(file), surfaces_(file) {}

    /// The level from which places are sampled: the coarsest that has, in each direction, as many
    /// samples as the whole raster would have at this distance of places.
    [[nodiscard]] int level_for(const Sampling& sampling) const;

    /// A raster of `type` with the values of the surface of level_for(sampling), those outside the
    /// raster being those at its border. A place is a hole if the nearest sample of the level is.
    /// Samples of a level are taken as RasterFile::decode_window gives them. Errors: BadFile.
    /// Complexity: O(places + samples of the level around them).
    [[nodiscard]] Result<Raster> values(const Sampling& sampling, SampleType type);

    /// The same of a quantity other than values: float32, uint8 for Hillshade; holes are NaN, and
    /// nodata is NaN or 0. `ground`: from coordinates in the unit of the physical heights (sample x
    /// scale) to samples of the raster.
    [[nodiscard]] Result<Raster> derived(Quantity quantity, const Sampling& sampling,
                                         const PlaceMap& ground);

  private:
    /// A window of a level.
    struct Window {
        int level = 0;
        LatticeBox box;
    };
    /// The window whose samples are these places; none if they are no samples.
    [[nodiscard]] std::optional<Window> samples_at(const Sampling& sampling) const;
    [[nodiscard]] Result<Raster> decode(const Window& window);
    /// The surface around places, which become places of its level.
    [[nodiscard]] Result<const RasterSurface*> surface_at(int level, Sampling& places);

    const RasterFile& file_;
    RasterSurfaces surfaces_;
    /// Of files that can only be decoded as a whole.
    struct Whole {
        int level = 0;
        Raster raster;
    };
    std::optional<Whole> whole_;
};

}  // namespace relief::codec
