#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "relief/core/polygon_mesh.h"
#include "relief/io/picture.h"

/// Meshes in perspective, shaded, drawn without a screen. See docs/pictures.md.
namespace relief::io {

enum class UpAxis : std::uint8_t { Z, Y };

enum class MeshShading : std::uint8_t {
    Smooth,  ///< normals of vertices, weighted by area; edges of more than 50 degrees stay sharp
    Facets,  ///< every face is flat
};

/// How edges and vertices look.
struct LineStyle {
    double width = 0;           ///< pixels; 0: none
    double opacity = 1;         ///< where nothing is in front
    double hidden_opacity = 0;  ///< where a surface is
    std::array<std::uint8_t, 3> colour = {40, 40, 48};
    double dot_radius = 0;  ///< pixels, at every vertex; 0: none
};

/// The viewer stands south-west of the mesh, and north is +y, or -z if y is up: so he sees what is
/// on the side of -y, or +z.
struct MeshPictureOptions {
    int width = 1200;           ///< pixels; the height follows from what is seen
    double azimuth = 215;       ///< where the viewer stands, degrees clockwise from north
    double altitude = 25;       ///< of the viewer, degrees above the horizon
    double field_of_view = 25;  ///< degrees; 0: parallel projection
    UpAxis up = UpAxis::Z;
    MeshShading shading = MeshShading::Smooth;
    HoleStyle background = HoleStyle::Grey;  ///< Grey: white paper; Transparent: four channels
    LineStyle edges = {};                    ///< of the mesh
    const PolygonMesh* net = nullptr;  ///< another mesh, of which only lines and dots are drawn
    LineStyle net_lines = {.width = 1.5,
                           .opacity = 0.9,
                           .hidden_opacity = 0.1,
                           .colour = {150, 20, 30},
                           .dot_radius = 3};
    /// One for each vertex of the mesh, or empty: shown by colours, with a legend below; those that
    /// are not finite have none. Numbers from 0 on: white to red; others: blue to white to red.
    std::span<const double> values = {};
    double scale = 0;  ///< value at the end of the colours; 0: the largest, rounded up to 1, 2 or 5
                       ///< x 10^k
    std::string unit = {};  ///< shown behind the legend's numbers
};

/// Draws a mesh with hidden surfaces and lines removed, anti-aliased by 3 x 3 samples a pixel. The
/// light comes from the viewer's left. Fronts of faces, which are seen counter-clockwise, have the
/// attribute "colour" if there is one (sRGB) and are pale otherwise; backs are brown. Polygons are
/// fans around their first corners, quads are cut where both triangles are large. The picture shows
/// the mesh and the net as a whole. A mesh without polygons gives an empty picture. Requires:
/// meshes pass relief::check. Complexity: O(n log n + pixels) in parallel, without edges O(n +
/// pixels); memory O(n).
[[nodiscard]] Image draw_mesh(const PolygonMesh& mesh, const MeshPictureOptions& options = {});

}  // namespace relief::io
