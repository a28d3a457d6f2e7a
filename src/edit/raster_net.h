#pragma once

#include "edit/model.h"
#include "edit/raster_tiles.h"

namespace relief::edit {

/// The control points of one level of a raster, or of a window of it: its own coefficients and what
/// moves of coarser levels add to them. Moves of the level itself are read from their field.
class RasterNet {
  public:
    /// Errors: BadFile. Complexity: O(window) and what its part of the file takes; with moves of
    /// coarser levels O(control points of the level).
    [[nodiscard]] static Result<RasterNet> create(const codec::RasterFile& file,
                                                  const std::vector<multires::Move>& moves,
                                                  int level, const LatticeBox& window);

    [[nodiscard]] int level() const { return level_; }
    [[nodiscard]] const LatticeBox& window() const { return window_; }
    /// Whether these moves change what is kept here.
    [[nodiscard]] bool depends_on(const std::vector<multires::Move>& moves) const;

    /// Requires: a point of the window.
    [[nodiscard]] std::array<double, 4> coefficient(const MoveFields& fields, std::int64_t row,
                                                    std::int64_t col) const;
    [[nodiscard]] Vec3<double> place(const TileFrame& frame, const MoveFields& fields,
                                     std::int64_t row, std::int64_t col) const;

  private:
    int level_ = 0;
    LatticeBox window_;
    multires::LevelCoefficients<double> coefficients_;
};

/// Rows and columns with the numbers that commands use: row by row.
[[nodiscard]] inline std::uint64_t number_of(const LatticeBox& all, std::int64_t row,
                                             std::int64_t col) {
    return static_cast<std::uint64_t>((row - all.row0) * all.cols + (col - all.col0));
}
struct LatticePoint {
    std::int64_t row = 0;
    std::int64_t col = 0;
};
[[nodiscard]] inline LatticePoint point_of(const LatticeBox& all, std::uint64_t number) {
    const auto n = static_cast<std::int64_t>(number);
    return {all.row0 + n / all.cols, all.col0 + n % all.cols};
}

/// Control points around each other in the directions of rows, columns and diagonals. Distances are
/// those in the plane.
class LatticeGraph final : public NetGraph {
  public:
    LatticeGraph(const LatticeBox& all, int level, const std::array<double, 2>& spacing)
        : all_(all), level_(level), spacing_(spacing) {}

    [[nodiscard]] std::uint64_t count() const override {
        return static_cast<std::uint64_t>(all_.count());
    }
    void neighbours(std::uint64_t point, std::vector<std::uint64_t>& out) const override;
    [[nodiscard]] double distance(std::uint64_t source, std::uint64_t from, double d,
                                  std::uint64_t to) const override;

  private:
    LatticeBox all_;
    int level_;
    std::array<double, 2> spacing_;
};

/// The points of a window, the lines between neighbours.
[[nodiscard]] NetGeometry draw_net(const RasterNet& net, const LatticeBox& all,
                                   const TileFrame& frame, const MoveFields& fields);

}  // namespace relief::edit
