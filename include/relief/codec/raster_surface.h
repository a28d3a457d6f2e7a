#pragma once

#include <map>
#include <span>
#include <vector>

#include "relief/codec/raster_codec.h"
#include "relief/multires/surface.h"

namespace relief::codec {

/// The smooth surface that a raster file describes, on a window of one of its levels. Points are in
/// sample coordinates of the level: (i, j) = (row, column). Windows of closed-loop files read their
/// tiles only, and give the bits of the whole surface. Several threads may evaluate it.
class RasterSurface {
  public:
    /// The window takes part with its border. Errors: InvalidArgument for a level or window that
    /// the file does not have; BadFile, also for damage.
    [[nodiscard]] static Result<RasterSurface> create(const RasterFile& file, int level,
                                                      const LatticeBox& window);

    [[nodiscard]] int components() const { return static_cast<int>(surfaces_.size()); }
    [[nodiscard]] const LatticeBox& window() const { return window_; }

    /// The sample nearest to (i, j) is valid. Requires: (i, j) in the window.
    [[nodiscard]] bool valid(double i, double j) const;

    /// As spline::BoxSurface::evaluate; points outside the window are moved to its border.
    Status evaluate(int component, std::span<const double> i, std::span<const double> j,
                    int derivatives, const spline::JetSpans<double>& out) const;

    /// As spline::BoxSurface::evaluate_grid.
    void evaluate_grid(int component, double i0, double di, double j0, double dj,
                       GridView<double> out) const;

  private:
    RasterSurface() = default;
    Status create_part(const RasterFile& file, int level, const LatticeBox& part,
                       const LatticeBox& all);
    Status create_whole(const RasterFile& file, int level);

    LatticeBox window_;
    double row0_ = 0;  ///< what the surfaces count from
    double col0_ = 0;
    Grid<std::uint8_t> mask_;
    std::vector<multires::Surface<double>> surfaces_;
};

/// The surfaces of a file's levels, kept where parts of them can not be made alone; of others the
/// last window's. Not for several threads at once.
class RasterSurfaces {
  public:
    /// The file must outlive this and keep its address.
    explicit RasterSurfaces(const RasterFile& file) : file_(file) {}

    /// One that takes part with the window at least; it lives until the next call. Errors: as
    /// RasterSurface::create.
    [[nodiscard]] Result<const RasterSurface*> around(int level, const LatticeBox& window);

  private:
    const RasterFile& file_;
    std::map<int, RasterSurface> surfaces_;
};

}  // namespace relief::codec
