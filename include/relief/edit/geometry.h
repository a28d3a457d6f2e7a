#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "relief/core/grid.h"
#include "relief/core/vec3.h"

/// What the editor draws: arrays ready for a graphics card, in page coordinates (docs/protocol.md).
namespace relief::edit {

/// x, y, z times 32767, and 0.
using PackedNormal = std::array<std::int16_t, 4>;
[[nodiscard]] PackedNormal packed_normal(const Vec3<double>& unit);

using Point = std::array<float, 3>;
[[nodiscard]] inline Point page_point(const Vec3<double>& p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

/// What is drawn beside places and normals.
struct Extras {
    bool error = false;      ///< distance from the original, with the sign of z or of the normal
    bool curvature = false;  ///< mean curvature, per data unit

    friend bool operator==(const Extras&, const Extras&) = default;
};

/// A whole mesh or spline. `lines` are its edges: pairs of vertices.
struct SurfaceGeometry {
    int level = 0;
    std::vector<Point> position;
    std::vector<PackedNormal> normal;
    std::vector<std::uint32_t> index;  ///< three a triangle
    std::vector<std::uint32_t> line;
    std::vector<float> error;              ///< empty: not asked for
    std::vector<float> curvature;          ///< empty: not asked for
    std::vector<std::array<float, 2>> uv;  ///< empty: there are none
};

/// New numbers of some of its vertices.
struct SurfacePatch {
    int level = 0;
    std::vector<std::uint32_t> at;
    std::vector<Point> position;
    std::vector<PackedNormal> normal;
    std::vector<float> error;
    std::vector<float> curvature;
};

/// Tile (row, col) of every 2^lod-th sample of a raster: samples row tile 2^lod .. (row + 1) tile
/// 2^lod, both ends included.
struct TileName {
    int lod = 0;
    std::int64_t row = 0;
    std::int64_t col = 0;

    friend auto operator<=>(const TileName&, const TileName&) = default;
};

/// Samples of a tile, or of a part of one.
struct TileGeometry {
    TileName tile;
    LatticeBox rect;  ///< rows and columns of the tile that follow
    /// Page places of the part's first and last sample, and the steps between all but the last
    /// two: the last sample of a raster is on its border.
    double x0 = 0, y0 = 0, x1 = 0, y1 = 0, dx = 0, dy = 0;
    std::vector<float> height;    ///< of a height field; else empty
    std::vector<Point> position;  ///< of a parametric surface; else empty
    std::vector<PackedNormal> normal;
    std::vector<std::uint8_t> valid;  ///< empty: all are
    std::vector<float> error;
    std::vector<float> curvature;
};

/// Control points of a level, or of a part of it. `point` is what commands call them; `line` are
/// pairs of places in these arrays.
struct NetGeometry {
    int level = 0;
    std::vector<Point> position;
    std::vector<std::uint32_t> point;
    std::vector<std::uint32_t> line;
    /// Corners of control triangles; empty for kinds without them.
    std::vector<std::array<Point, 3>> corner;
};

}  // namespace relief::edit
