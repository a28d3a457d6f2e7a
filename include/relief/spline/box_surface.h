#pragma once

#include <memory>
#include <span>

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/spline/box_spline.h"

namespace relief::spline {

/// The surface s(i, j) = sum of c(k) M_ddd((i, j) - k) on [0, rows - 1] x [0, cols - 1]. Invariant:
/// the coefficients on their rows x cols box together with the ring of neighbours that reach into
/// it, made by the border rule of relief/spline/lattice_filters.h. Immutable; cheap to move;
/// several threads may evaluate it.
///
/// A parametric surface in space is one BoxSurface a coordinate. Points are in lattice units, i
/// down the rows, j along the columns; points outside the domain are moved to its border, NaN
/// counts as 0. All ways to evaluate agree to the bit at equal points, except `evaluate_grid`, see
/// there.
template <class T>
class BoxSurface {
  public:
    /// Copies the coefficients. Errors: InvalidArgument for an order outside 1 .. 4, BadInput for
    /// an empty grid.
    [[nodiscard]] static Result<BoxSurface> create(GridView<const T> coefficients, int order);

    BoxSurface(BoxSurface&&) noexcept;
    BoxSurface& operator=(BoxSurface&&) noexcept;
    ~BoxSurface();

    [[nodiscard]] int order() const;
    [[nodiscard]] std::int64_t rows() const;
    [[nodiscard]] std::int64_t cols() const;
    /// Whether (i, j) lies in the domain, border included.
    [[nodiscard]] bool contains(double i, double j) const;

    /// Value, gradient and Hessian at one point. Order 1 has Hessian zero; its gradient on a
    /// lattice edge is that of the triangle with the larger i, j or, on a diagonal, i.
    [[nodiscard]] SurfaceJet<T> jet(double i, double j) const;

    /// Values (derivatives = 0), gradients too (1), Hessians too (2) at many points; in parallel,
    /// and with vector instructions, all orders. Errors: InvalidArgument if derivatives is not 0, 1
    /// or 2 or a needed span has not the size of i and j. Complexity: O(points).
    [[nodiscard]] Status evaluate(std::span<const T> i, std::span<const T> j, int derivatives,
                                  const JetSpans<T>& out) const;

    /// out(r, c) = value at (i0 + r di, j0 + c dj); any real steps, also negative. If a small
    /// multiple of dj is a whole number, columns repeat the same stencils, which are then applied
    /// as filters: faster, and equal to `jet` only up to the rounding of values and positions.
    /// Complexity: O(out).
    void evaluate_grid(double i0, double di, double j0, double dj, GridView<T> out) const;

  private:
    struct Data;
    explicit BoxSurface(std::unique_ptr<const Data> data);
    std::unique_ptr<const Data> data_;
};

}  // namespace relief::spline
