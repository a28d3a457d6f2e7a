#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "relief/io/picture.h"

/// Surfaces and control nets in perspective, drawn without a screen.
namespace relief::io {

/// A grid of points in space, x east, y north, z up.
struct Sheet {
    std::array<Grid<double>, 3> xyz;
    Grid<std::uint8_t> mask;  ///< empty: all valid
};

/// Heights over a plan, row 0 north, scaled by the exaggeration; `every` k-th row and column only.
/// Coarser nets of the same ground line up when their `origin` (column, row of their first sample)
/// is given in metres. Requires: every >= 1. Complexity: O(samples).
[[nodiscard]] Sheet height_sheet(Heights z, Mask mask, CellSize cell, double exaggeration,
                                 std::array<double, 2> origin = {0, 0}, std::int64_t every = 1);

/// A parametric surface. Requires: planes of one size. Complexity: O(samples).
[[nodiscard]] Sheet point_sheet(Heights x, Heights y, Heights z, Mask mask);

enum class SheetFill : std::uint8_t {
    None,      ///< lines only, faint where a surface hides them
    Paper,     ///< white, shaded
    ByHeight,  ///< colours of the height ramp, shaded
};

struct SheetStyle {
    SheetFill fill = SheetFill::ByHeight;
    int line_every = 0;     ///< draw every k-th row and column; 0: none
    double line_width = 1;  ///< pixels
    double line_opacity = 1;
    std::array<std::uint8_t, 3> line_colour = {40, 40, 48};
    double dot_radius = 0;  ///< pixels, at every drawn crossing of lines; 0: none
};

struct Layer {
    const Sheet* sheet = nullptr;
    SheetStyle style = {};
};

struct ViewOptions {
    int width = 1200;           ///< pixels; the height follows from what is seen
    double azimuth = 205;       ///< where the viewer stands, degrees clockwise from north
    double altitude = 35;       ///< of the viewer, degrees above the horizon
    double field_of_view = 25;  ///< degrees; 0: parallel projection
    HoleStyle background = HoleStyle::Grey;  ///< Grey: white paper; Transparent: four channels
    LightOptions light =
        {};  ///< vertical_exaggeration is for wireframe(); draw_sheets draws points as they are
};

/// Draws layers with hidden surfaces removed, anti-aliased. Lines lie on their own surface; the
/// height ramp spans all filled layers. Sheets with more than about two samples a pixel should be
/// thinned by the caller. An empty scene gives an empty picture. Complexity: O(samples + pixels).
[[nodiscard]] Image draw_sheets(std::span<const Layer> layers, const ViewOptions& view = {});

/// One height field with about `lines` of its grid lines each way (0: none), thinned to the
/// picture's resolution.
[[nodiscard]] Image wireframe(Heights z, Mask mask, CellSize cell, const ViewOptions& view = {},
                              int lines = 60);

}  // namespace relief::io
