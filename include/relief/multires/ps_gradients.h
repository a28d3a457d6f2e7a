#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/vec2.h"
#include "relief/mesh/triangulation.h"

/// Gradients at the vertices of a triangulation from the values there, so that a C1 spline can pass
/// through scattered data. Source: powell-sabin.md section 12 (b); docs/powell-sabin.md.
namespace relief::multires::ps {

enum class GradientRule {
    /// Local fits of degree 1, 2 and 3 blended by how well they predict values left out: third
    /// order on smooth data, and no worse than linear interpolation on rough and noisy ones.
    Adaptive,
    Quadratic,  ///< a weighted quadratic through each vertex; for smooth data only
    Plane,      ///< the plane through each vertex nearest to those around it
    Zero,
};

/// "adaptive", "quadratic", "plane", "zero". Errors: InvalidArgument listing the names.
[[nodiscard]] Result<GradientRule> gradient_rule_from_name(std::string_view name);

struct GradientOptions {
    GradientRule rule = GradientRule::Adaptive;
    /// How far vertices whose value looks like noise are tilted; 0: not at all. Adaptive only.
    double tilt = 0.6;
    /// How far beyond the values around it a vertex's plane may reach half-way to its neighbours,
    /// in units of their range; infinity: no limit. Adaptive only.
    double limit = 1;
};

/// One gradient a vertex. Exact for polynomials up to degree 3 (Adaptive), 2 (Quadratic) or 1
/// (Plane) where the vertices around determine one. Sums have a fixed order: the same bits for any
/// number of threads and any instruction set.
/// Errors: `size_mismatch`, `non_finite_data` (also beyond 1e150, where squares overflow) naming
/// the vertex; InvalidArgument for a tilt or limit that is negative or not a number.
/// Complexity: O(n), in parallel; 12 numbers a vertex of memory between its two passes.
[[nodiscard]] Result<std::vector<Vec2>> estimate_gradients(const mesh::Triangulation& mesh,
                                                           std::span<const double> values,
                                                           const GradientOptions& options = {});

}  // namespace relief::multires::ps
