#pragma once

#include <span>
#include <utility>
#include <variant>

#include "relief/multires/pyramid.h"
#include "relief/spline/box_surface.h"
#include "relief/spline/cubic_surface.h"
#include "relief/spline/fvs_surface.h"

namespace relief::multires {

/// The surface that scaling coefficients of a scheme describe, ready to be evaluated: a
/// spline::BoxSurface, a spline::CubicSurface for scheme `cubic`, a spline::FvsSurface for `fvs`
/// (linear where the lattice is one row or column). Points are in units of the coefficients'
/// lattice, the first of which is (0, 0). Immutable; cheap to move.
template <class T>
class Surface {
  public:
    /// One component. Errors: BadInput for an empty grid; InvalidArgument for an order that the
    /// scheme's surfaces do not have. Complexity: O(coefficients).
    [[nodiscard]] static Result<Surface> create(const SchemeSpec& spec,
                                                GridView<const T> coefficients) {
        if (spec.id == SchemeId::Cubic) {
            RELIEF_TRY(auto surface, spline::CubicSurface<T>::create(coefficients));
            return Surface(std::move(surface));
        }
        const bool has_cells = coefficients.rows > 1 && coefficients.cols > 1;
        if (spec.id == SchemeId::Fvs && has_cells)
            return create_fvs(spline::RasterPart<T>::whole(coefficients),
                              {0, 0, coefficients.rows, coefficients.cols});
        const int order = spec.id == SchemeId::Fvs ? 1 : spec.order;
        RELIEF_TRY(auto surface, spline::BoxSurface<T>::create(coefficients, order));
        return Surface(std::move(surface));
    }

    /// Scheme `fvs` on a window of a raster: as spline::FvsSurface::create.
    [[nodiscard]] static Result<Surface> create_fvs(const spline::RasterPart<T>& part,
                                                    const LatticeBox& window) {
        RELIEF_TRY(auto surface, spline::FvsSurface<T>::create(part, window));
        return Surface(std::move(surface));
    }

    /// As BoxSurface::jet.
    [[nodiscard]] spline::SurfaceJet<T> jet(double i, double j) const {
        return std::visit([&](const auto& surface) { return surface.jet(i, j); }, surface_);
    }
    /// As BoxSurface::evaluate.
    [[nodiscard]] Status evaluate(std::span<const T> i, std::span<const T> j, int derivatives,
                                  const spline::JetSpans<T>& out) const {
        return std::visit(
            [&](const auto& surface) { return surface.evaluate(i, j, derivatives, out); },
            surface_);
    }
    /// As BoxSurface::evaluate_grid.
    void evaluate_grid(double i0, double di, double j0, double dj, GridView<T> out) const {
        std::visit([&](const auto& surface) { surface.evaluate_grid(i0, di, j0, dj, out); },
                   surface_);
    }

  private:
    template <class Kind>
    explicit Surface(Kind surface) : surface_(std::move(surface)) {}
    std::variant<spline::BoxSurface<T>, spline::CubicSurface<T>, spline::FvsSurface<T>> surface_;
};

}  // namespace relief::multires
