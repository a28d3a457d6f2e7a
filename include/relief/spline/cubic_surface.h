#pragma once

#include <memory>
#include <span>

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/spline/jet.h"

namespace relief::spline {

/// The bicubic C2 spline through values on a lattice: s(i, j) on [0, rows - 1] x [0, cols - 1], the
/// tensor product of cubic B-splines whose coefficients relief/spline/cubic_filters.h finds.
/// Invariant: these coefficients, continued by whole-sample mirror: derivatives across a border are
/// zero there. Immutable; cheap to move; several threads may evaluate it.
///
/// A parametric surface in space is one CubicSurface a coordinate. Points are in lattice units, i
/// down the rows, j along the columns; points outside the domain are moved to its border, NaN
/// counts as 0. All ways to evaluate agree to the bit at equal points.
template <class T>
class CubicSurface {
  public:
    /// Finds the coefficients of the surface through `values`. Errors: BadInput for an empty grid.
    /// Complexity: O(values), in parallel.
    [[nodiscard]] static Result<CubicSurface> create(GridView<const T> values);

    CubicSurface(CubicSurface&&) noexcept;
    CubicSurface& operator=(CubicSurface&&) noexcept;
    ~CubicSurface();

    [[nodiscard]] std::int64_t rows() const;
    [[nodiscard]] std::int64_t cols() const;
    /// Whether (i, j) lies in the domain, border included.
    [[nodiscard]] bool contains(double i, double j) const;

    /// Value, gradient and Hessian at one point.
    [[nodiscard]] SurfaceJet<T> jet(double i, double j) const;

    /// Values (derivatives = 0), gradients too (1), Hessians too (2) at many points, in parallel.
    /// Errors: InvalidArgument if derivatives is not 0, 1 or 2 or a needed span has not the size of
    /// i and j. Complexity: O(points).
    [[nodiscard]] Status evaluate(std::span<const T> i, std::span<const T> j, int derivatives,
                                  const JetSpans<T>& out) const;

    /// out(r, c) = value at (i0 + r di, j0 + c dj); any real steps, also negative. Complexity: O(1)
    /// a value of `out`, and for each of its rows O(1) a lattice column between its ends.
    void evaluate_grid(double i0, double di, double j0, double dj, GridView<T> out) const;

  private:
    struct Data;
    explicit CubicSurface(std::unique_ptr<const Data> data);
    std::unique_ptr<const Data> data_;
};

}  // namespace relief::spline
