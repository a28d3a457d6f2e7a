#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "relief/core/grid.h"
#include "relief/io/image.h"
#include "relief/io/raster.h"

/// Pictures of surfaces, drawn without a screen. Row 0 of a grid is the top (north) of a plan view.
/// Masks: 1 valid, 0 hole, an empty view is all valid; samples that are not finite are holes as
/// well. Pictures are the same for any thread count. See docs/pictures.md.
namespace relief::io {

using Heights = GridView<const double>;
using Mask = GridView<const std::uint8_t>;

/// How holes look in plan views.
enum class HoleStyle : std::uint8_t {
    Grey,         ///< neutral light grey
    Transparent,  ///< the picture has four channels
};

/// Where the light comes from.
struct LightOptions {
    double azimuth = 315;              ///< degrees clockwise from north
    double altitude = 45;              ///< degrees above the horizon, 0 .. 90
    double vertical_exaggeration = 0;  ///< > 0: factor; 0: such that a typical slope shows well
    bool multidirectional =
        false;  ///< four lights at azimuth - 90, - 45, 0, + 45, each strong across the slope
};

/// How a plan view is laid out.
struct PictureOptions {
    LightOptions light = {};
    HoleStyle holes = HoleStyle::Grey;
    int width =
        0;  ///< pixels, 0: one a sample; else the height follows from the ground's proportions
};

/// The vertical exaggeration that makes the mean slope of the valid samples 22 degrees; 1 for a
/// level surface. Complexity: O(samples).
[[nodiscard]] double auto_exaggeration(Heights z, Mask mask, CellSize cell);

/// Brightness 0 .. 1 of a matt surface: the cosine between normal and light, 0 where it faces away.
/// Slopes by Horn's 3 x 3 differences; beside borders and holes by differences of the neighbours
/// there are on each axis (none: level), so that a plane is exact there too. Holes are NaN.
/// Multidirectional: weights sin^2(aspect - azimuth) / 2, after Mark (USGS OFR 92-422). Complexity:
/// O(samples), in parallel.
[[nodiscard]] Grid<double> illumination(Heights z, Mask mask, CellSize cell,
                                        const LightOptions& light = {});

/// A colour of the height ramp, sRGB. Land, height 0 .. 1: green, ochre, brown, near white; sea,
/// height -1 .. 0: deep to pale blue. Lightness (OKLab) grows evenly with height within land and
/// within sea.
[[nodiscard]] std::array<std::uint8_t, 3> height_colour(double height);

/// A colour of the difference ramp, sRGB: -1 blue, 0 near white, 1 red; the two arms have the same
/// lightness.
[[nodiscard]] std::array<std::uint8_t, 3> difference_colour(double difference);

/// Grey shaded relief.
[[nodiscard]] Image hillshade(Heights z, Mask mask, CellSize cell,
                              const PictureOptions& options = {});

/// Whether light lies over a coloured picture.
enum class Shading : std::uint8_t { Flat, Shaded };

/// Heights as colours of the height ramp: 0 is the coast when the data lies on both sides of it,
/// else the land ramp is stretched over the range of the data.
[[nodiscard]] Image colour_by_height(Heights z, Mask mask, CellSize cell,
                                     const PictureOptions& options = {},
                                     Shading shading = Shading::Shaded);

/// An image laid over the ground (a satellite picture, a map), stretched to the raster's extent and
/// shaded by its relief. Requires: an image with pixels.
[[nodiscard]] Image drape(Heights z, Mask mask, CellSize cell, const Image& image,
                          const PictureOptions& options = {});

struct ErrorMapOptions {
    double scale = 0;  ///< difference at the ends of the ramp; 0: the largest one, rounded up to 1,
                       ///< 2 or 5 x 10^k
    std::string unit;  ///< shown behind the legend's numbers; letters outside the built-in font are
                       ///< left out
    PictureOptions picture = {};
};

/// surface - reference as colours symmetric about 0, with a legend bar below. Requires: grids of
/// one size.
[[nodiscard]] Image error_map(Heights surface, Heights reference, Mask mask, CellSize cell,
                              const ErrorMapOptions& options = {});

/// The picture with a line of text below it, on white, 21 pixels high or less where it would take
/// more than three quarters of the width. The built-in font has digits, lower-case letters and + -
/// . , : / %; other characters are left out.
[[nodiscard]] Image with_caption(const Image& picture, std::string_view text);

/// Averages (down) or interpolates (up) in linear light to a new size. Alpha is respected.
[[nodiscard]] Image resize(const Image& image, int width, int height);

}  // namespace relief::io
