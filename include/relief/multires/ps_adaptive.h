#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "relief/multires/ps_fit.h"

/// Powell-Sabin splines that come as near to scattered points as asked for, with few vertices.
/// Source: powell-sabin.md section 12 (c); docs/powell-sabin.md.
namespace relief::multires::ps {

struct ScatteredData {
    std::span<const Vec2> points;
    std::span<const std::vector<double>> components;  ///< one to three, each a value a point
    std::span<const double> weights;  ///< of the least squares, not negative; empty: all 1
};

/// The Delaunay triangulation of about `count` of the points, all over the domain: those of the
/// convex hull, of each cell of a lattice that which is nearest to its middle, and a few more, so
/// that no point lies outside. Errors: `non_finite_input`, those of mesh::delaunay. Complexity:
/// O(n log n).
[[nodiscard]] Result<mesh::Triangulation> spread_triangulation(std::span<const Vec2> points,
                                                               std::size_t count);

struct AdaptiveOptions {
    double max_error = 0;  ///< of every point, whatever its weight, in each component
    /// Vertices to begin with, beside those of the convex hull.
    std::size_t first_vertices = 16;
    std::size_t most_vertices = static_cast<std::size_t>(-1);
    double smoothing = 1e-10;  ///< as LeastSquares::fit; above 0
    Energy energy = Energy::ThinPlate;
    /// Called with the part of the points that are within the bound; false cancels.
    std::function<bool(double)> progress = {};
};

struct AdaptiveSurface {
    Space space;
    std::vector<Coefficients> components;
    FitReport report;
    std::size_t beyond = 0;  ///< how many points are not within the bound
    std::string reason;      ///< why they are not; empty if there are none
    int rounds = 0;
};

/// Fits a spline on the Delaunay triangulation of some of the points, makes those that are farthest
/// off vertices, and repeats that until all points are within the bound. A vertex that least
/// squares leave beyond it is moved into it, so that there is an end: at the latest when all places
/// are vertices. No point lies outside the triangulation, unless most_vertices is too few for that.
/// Points at the same place need values no farther apart than twice the bound.
/// Errors: `component_count`, `size_mismatch`, `non_finite_input`, those of mesh::delaunay and
/// LeastSquares; InvalidArgument for a bound that is negative or not a number; Cancelled.
/// Complexity: that of some ten fits, the last one with the most vertices.
[[nodiscard]] Result<AdaptiveSurface> fit_within(const ScatteredData& data,
                                                 const AdaptiveOptions& options);

}  // namespace relief::multires::ps
