#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/spline/box_surface.h"
#include "relief/spline/fvs_grid.h"

namespace relief::spline {

/// A C1 cubic spline on the cells of a raster or of a window of it, in sample coordinates of the
/// raster: i down the rows, j along the columns. Points outside the window are moved to its border,
/// NaN counts as its first row or column. Immutable; several threads may evaluate it.
///
/// A window's surface equals that of the whole raster to the bit, and so do `jet` and `evaluate` at
/// equal points. Every vertex value is met exactly. On a line where two triangles meet (the
/// diagonals and sides of cells) only the Hessian jumps; with (x, y) the place in the cell, it is
/// that of the triangle at side y = 0 if y <= x and x + y <= 1, at x = 1 if y <= x and x + y > 1,
/// at y = 1 if y > x and x + y >= 1, at x = 0 otherwise.
/// Source: specification of hierarchical FVS splines, sections 2 and 10.
template <class T>
class FvsSurface {
  public:
    /// From nodal data; vertex (0, 0) stands at (row0, col0). Derivatives are taken per a and b and
    /// given back per cell. Errors: BadInput without a cell, InvalidArgument for a negative origin.
    [[nodiscard]] static Result<FvsSurface> create(FvsGrid<T> grid, std::int64_t row0 = 0,
                                                   std::int64_t col0 = 0);
    /// Through the samples of a window (`estimate_fvs_grid`), of which the part must cover
    /// samples_for(window, part.rows, part.cols). Errors: BadInput if a side of the raster has less
    /// than 2 samples, InvalidArgument as estimate_fvs_grid.
    [[nodiscard]] static Result<FvsSurface> create(const RasterPart<T>& part,
                                                   const LatticeBox& window);
    /// The samples on which a window of a raster of rows x cols depends: `needed_box` of its cells,
    /// with those that begin on its last row and column. Requires: the window lies in the raster.
    [[nodiscard]] static LatticeBox samples_for(const LatticeBox& window, std::int64_t rows,
                                                std::int64_t cols);

    FvsSurface(FvsSurface&&) noexcept;
    FvsSurface& operator=(FvsSurface&&) noexcept;
    ~FvsSurface();

    /// The vertices: the window.
    [[nodiscard]] LatticeBox box() const;
    /// Whether (i, j) lies in the window, border included.
    [[nodiscard]] bool contains(double i, double j) const;

    /// Value, gradient and Hessian at one point.
    [[nodiscard]] SurfaceJet<T> jet(double i, double j) const;

    /// Values (derivatives = 0), gradients too (1), Hessians too (2) at many points; in parallel,
    /// with vector instructions. Errors: InvalidArgument if derivatives is not 0, 1 or 2 or a
    /// needed span has not the size of i and j. Complexity: O(points).
    [[nodiscard]] Status evaluate(std::span<const T> i, std::span<const T> j, int derivatives,
                                  const JetSpans<T>& out) const;

    /// out(r, c) = value at (i0 + r di, j0 + c dj); any real steps, also negative. If a small
    /// multiple of dj is a whole number, columns repeat the same stencils, which are then applied
    /// as filters: faster, and equal to `jet` up to rounding only. Where all points are multiples
    /// of 2^-16, windows still give the bits of the whole raster. Complexity: O(out).
    void evaluate_grid(double i0, double di, double j0, double dj, GridView<T> out) const;

    /// evaluate_grid of the surface through a raster, straight from its samples, to the bit,
    /// without keeping nodal data of more than some rows. Points outside the raster are moved to
    /// its border. Errors: BadInput if a side has less than 2 samples, InvalidArgument if the part
    /// does not cover `resampling_box`.
    [[nodiscard]] static Status resample(const RasterPart<T>& part, double i0, double di, double j0,
                                         double dj, GridView<T> out);

  private:
    struct Data;
    explicit FvsSurface(std::unique_ptr<const Data> data);
    std::unique_ptr<const Data> data_;
};

/// The samples that FvsSurface::resample needs for rows x cols points. Requires: at least 1 point
/// and 2 samples a side.
[[nodiscard]] LatticeBox resampling_box(double i0, double di, std::int64_t rows, double j0,
                                        double dj, std::int64_t cols, std::int64_t raster_rows,
                                        std::int64_t raster_cols);

}  // namespace relief::spline
