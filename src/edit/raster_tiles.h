#pragma once

#include "edit/raster_jets.h"
#include "relief/edit/session.h"

/// Tiles of a raster's lattice, and how their jets are drawn.
namespace relief::edit {

/// Where the samples of a raster are: its finest lattice, cut into tiles at every level of detail.
struct TileGrid {
    std::int64_t rows = 0;  ///< of the lattice, margin included
    std::int64_t cols = 0;
    codec::LatticeMargin margin;
    std::array<double, 2> spacing{1, 1};

    static constexpr int kTile = 128;

    /// The level of detail at which one tile is everything.
    [[nodiscard]] int coarsest() const;
    /// Rows and columns of a tile's samples. Errors: InvalidArgument if there is no such tile.
    [[nodiscard]] Result<LatticeBox> rect_of(const TileName& name) const;
    /// The samples of a part of a tile. Requires: a part of rect_of(name).
    [[nodiscard]] Places places_of(const TileName& name, const LatticeBox& rect) const;
    /// The samples of a tile that lie in a box of the lattice.
    [[nodiscard]] LatticeBox part_in(const TileName& name, const LatticeBox& box) const;
    /// From a place of the lattice to page coordinates x and y, and back: x of `lattice_place` is
    /// the row.
    [[nodiscard]] Vec2 page_place(double row, double col) const;
    [[nodiscard]] Vec2 lattice_place(Vec2 page) const;
};

/// A frame for the samples' geometry: page coordinates are relative to `origin`.
struct TileFrame {
    const TileGrid* grid = nullptr;
    Vec3<double> origin;
    bool parametric = false;

    /// Place k of places, in page coordinates.
    [[nodiscard]] Vec3<double> place(const std::vector<Jets>& components, const Places& places,
                                     std::size_t k) const;
    [[nodiscard]] Vec3<double> normal(const std::vector<Jets>& components, std::size_t k) const;
    /// Mean curvature, positive where the surface is a valley seen from its normal's side.
    /// Requires: second derivatives.
    [[nodiscard]] double curvature(const std::vector<Jets>& components, std::size_t k) const;

    /// Places and normals, validity, curvature if there are second derivatives.
    void draw(const Places& places, const OriginalSurfaces::Part& part, TileGeometry& out) const;
    /// How far the part is off the original, along z or the normal. Requires: the same places.
    void draw_errors(const Places& places, const OriginalSurfaces::Part& part,
                     const OriginalSurfaces::Part& original, TileGeometry& out) const;
};

}  // namespace relief::edit
