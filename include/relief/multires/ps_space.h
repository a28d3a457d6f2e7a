#pragma once

#include <array>
#include <span>
#include <vector>

#include "relief/multires/ps_split.h"

/// The space of Powell-Sabin splines on a triangulation and its normalised B-splines: three a
/// vertex, not negative, with the sum 1, each zero outside the triangles at its vertex. Source:
/// powell-sabin.md sections 4 and 5; docs/powell-sabin.md.
namespace relief::multires::ps {

/// The coefficients of a vertex: the heights of its control triangle's corners.
using Heights = std::array<double, 3>;
/// A spline: the coefficients of each vertex, or their values and gradients there.
using Coefficients = std::vector<Heights>;
using TangentPlanes = std::vector<spline::TangentPlane>;

/// A triangulation, its split and its control triangles. Coefficients travel separately: any number
/// of splines, or components of one, use the same space. Invariant: made by `make_space` or a
/// refinement; control[i] contains the points halfway from vertex i to the points Z and R around
/// it.
struct Space {
    mesh::Triangulation mesh;
    Split split;
    std::vector<TriangleCorners> control;  ///< Q of each vertex, relative to it; may be clockwise

    [[nodiscard]] spline::PsElement element(mesh::Index t) const {
        return ps::element(mesh, split, t);
    }
    /// The nine B-splines of the corners of a triangle, those of corner k first at 3k.
    [[nodiscard]] spline::PsBasis basis(mesh::Index t) const;
};

/// The space of smallest control triangles. Errors: those of `split`; `degenerate_hull` if the
/// points that a control triangle must contain are collinear. Complexity: O(n) for bounded
/// valences.
[[nodiscard]] Result<Space> make_space(mesh::Triangulation mesh, const SplitOptions& options = {});

/// The tangent planes of the three B-splines of a vertex: their heights are the barycentric
/// coordinates in the control triangle.
[[nodiscard]] std::array<spline::TangentPlane, 3> basis_planes(const TriangleCorners& control);

/// The plane through the corners of a control triangle, and the heights of a plane there.
[[nodiscard]] spline::TangentPlane tangent_plane(const TriangleCorners& control,
                                                 const Heights& heights);
[[nodiscard]] Heights heights(const TriangleCorners& control, const spline::TangentPlane& plane);

/// The same for all vertices. Requires: one element a vertex.
[[nodiscard]] TangentPlanes tangent_planes(const Space& space, std::span<const Heights> spline);
[[nodiscard]] Coefficients coefficients(const Space& space,
                                        std::span<const spline::TangentPlane> planes);

/// Errors: `size_mismatch`, and `non_finite_input` for a coefficient that is not finite or beyond
/// 1e150, where squares overflow.
[[nodiscard]] Status check(const mesh::PlaneTriangles& mesh, std::span<const Heights> spline);
[[nodiscard]] Status check(const mesh::PlaneTriangles& mesh,
                           std::span<const spline::TangentPlane> planes);

/// The largest part, in barycentric coordinates, by which a control triangle fails to contain the
/// points that it must; 0 if none does. Complexity: O(n).
[[nodiscard]] double enclosure_excess(const Space& space);

}  // namespace relief::multires::ps
