#pragma once

#include <memory>
#include <span>
#include <vector>

#include "relief/mesh/delaunay.h"
#include "relief/mesh/triangle_locator.h"
#include "relief/multires/ps_gradients.h"
#include "relief/multires/ps_surface.h"

/// Scattered values to a C1 function in one step. Source: powell-sabin.md section 12 (a) and (b);
/// docs/powell-sabin.md.
namespace relief::multires::ps {

struct InterpolationOptions {
    mesh::DelaunayOptions delaunay;
    GradientOptions gradients;
};

/// The Powell-Sabin spline through values at points, with what evaluation needs and no more: 590
/// bytes a vertex. Immutable; several threads may ask. Whoever wants coefficients, levels or a file
/// makes a Space instead.
class Interpolant {
  public:
    /// Points at one place, or merged by the options, have the mean of their values. Errors: those
    /// of `mesh::delaunay`, `split` and `estimate_gradients`; `size_mismatch`, `non_finite_data`
    /// naming the point. Complexity: O(n log n); memory: up to about 850 bytes a point.
    [[nodiscard]] static Result<Interpolant> create(std::span<const Vec2> points,
                                                    std::span<const double> values,
                                                    const InterpolationOptions& options = {});

    [[nodiscard]] const mesh::PlaneTriangles& triangles() const { return *triangles_; }
    [[nodiscard]] const Surface& surface() const { return surface_; }
    [[nodiscard]] const mesh::TriangleLocator& locator() const { return locator_; }

    /// As the functions of these names for a surface.
    [[nodiscard]] Status evaluate(std::span<const Vec2> points, std::span<spline::PlaneJet> out,
                                  Outside outside = Outside::Reject) const {
        return ps::evaluate(surface_, locator_, points, out, outside);
    }
    [[nodiscard]] Status evaluate_raster(const RasterFrame& frame, GridView<double> out,
                                         Outside outside = Outside::Nan) const {
        return ps::evaluate_raster(surface_, frame, out, 0, outside, &locator_);
    }

  private:
    Interpolant(std::unique_ptr<const mesh::PlaneTriangles> triangles, Surface surface,
                mesh::TriangleLocator locator)
        : triangles_(std::move(triangles)),
          surface_(std::move(surface)),
          locator_(std::move(locator)) {}

    std::unique_ptr<const mesh::PlaneTriangles> triangles_;
    Surface surface_;
    mesh::TriangleLocator locator_;
};

/// The mean at each vertex of the values of its points, weighted; the plain mean where all weights
/// are zero. `vertex_of_point`: of each value, below vertex_count, none of which is without.
/// `weights`: not negative; empty: all 1. Complexity: O(n).
[[nodiscard]] std::vector<double> vertex_means(std::size_t vertex_count,
                                               std::span<const mesh::Index> vertex_of_point,
                                               std::span<const double> values,
                                               std::span<const double> weights = {});

}  // namespace relief::multires::ps
