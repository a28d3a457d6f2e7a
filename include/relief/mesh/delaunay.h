#pragma once

#include <span>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/vec2.h"
#include "relief/mesh/triangulation.h"

/// Triangulations of scattered points. Source: powell-sabin.md section 1; docs/triangulations.md.
namespace relief::mesh {

struct DelaunayOptions {
    /// Slivers at the hull are peeled off: triangles on a boundary edge AB whose third corner C is
    /// an interior vertex, projects into AB and has orient(A, B, C) < peel |AB|^2, repeatedly. No
    /// vertex is lost. 0 keeps the convex hull, but for triangles that `build` would refuse.
    double peel = 3e-4;
    /// Points that are closer than this, also over others in between, become one vertex at the
    /// place of the first of them. 0: only those at one place.
    double merge_distance = 0;
};

struct Delaunay {
    Triangulation mesh;  ///< vertices along a Hilbert curve, triangles by their lowest vertices
    /// Of each point its vertex, which points share that are at one place or were merged.
    std::vector<Index> vertex_of_point;
};

/// The triangulation whose triangles have no point inside their circumcircles. Vertices lie on the
/// lattice with 2^50 to 2^51 steps, a power of two each, across the larger side of the bounding
/// box: points are moved by 2^-51 of it at most, those that fall on the same place become one
/// vertex, and all decisions are exact there. Four points on a circle are joined by the shorter
/// diagonal, of equal ones by that which rises to the right, so that lattices are cut in one
/// direction. The mesh depends on the set of points only: not on their order, threads or machines.
///
/// Errors, all BadInput, with a name as in `build`: `too_many_points` (2^31 / 6),
/// `non_finite_input` (also beyond 1e150), `too_few_points` (fewer than three places),
/// `collinear_points`, `degenerate_triangle` (points too close to each other or to a line, see
/// `build`). Complexity: O(n log n), whatever the points (expected, over the choice of a fixed
/// order); memory: up to about 200 bytes a point, of which the result keeps 116.
[[nodiscard]] Result<Delaunay> delaunay(std::span<const Vec2> points,
                                        const DelaunayOptions& options = {});

}  // namespace relief::mesh
