#pragma once

#include <memory>
#include <span>

#include "relief/core/buffer.h"
#include "relief/mesh/triangulation.h"

namespace relief::mesh {

/// A triangle and a point in it, relative to the mesh's origin.
struct TrianglePlace {
    Index triangle = kNone;
    Vec2 point;
};

/// Finds the triangle of a point, in a grid of cells with lists of the triangles that reach into
/// them; where too many do, in a tree of boxes. Immutable; several threads may ask. Source:
/// powell-sabin.md section 10.
class TriangleLocator {
  public:
    /// The triangles must outlive the locator and keep their address; the boundary need not.
    /// Complexity: O(n + b log b) with b boundary edges, and O(n log n) for parts of the mesh that
    /// are far finer than the rest. Memory: about 20 bytes a triangle.
    TriangleLocator(const PlaneTriangles& triangles, std::span<const TriangleSide> boundary);
    explicit TriangleLocator(const Triangulation& mesh)
        : TriangleLocator(mesh, boundary_sides(mesh)) {}
    TriangleLocator(TriangleLocator&&) noexcept;
    TriangleLocator& operator=(TriangleLocator&&) noexcept;
    ~TriangleLocator();

    /// The triangle that contains the point, given in the coordinates of the mesh's source: its
    /// barycentric coordinates are at least -1e-12. The smallest number if there are several, as on
    /// edges; kNone outside the domain, in a hole, and for a point that is not finite. Depends on
    /// nothing but the point. Complexity: O(1), O(log n) in the finer parts.
    [[nodiscard]] Index locate(Vec2 point) const;

    /// The same for many points, in parallel: triangles[k] is locate(points[k]). Points may come in
    /// any order; they are visited cell by cell. Requires: the spans have the same size, at most
    /// 2^32 - 1.
    void locate(std::span<const Vec2> points, std::span<Index> triangles) const;

    /// An order of the points, by number, in which they lie near each other: whoever locates many
    /// and looks at their triangles finds both in the cache. Empty if there are too few for the
    /// order to be worth its cost. Requires: at most 2^32 - 1 points.
    [[nodiscard]] Buffer<Index> visiting_order(std::span<const Vec2> points) const;

    /// The point itself with its triangle, or the nearest point of the boundary, on the smallest of
    /// several equally near edges. Requires: the point is finite, the mesh has triangles.
    [[nodiscard]] TrianglePlace nearest(Vec2 point) const;

  private:
    struct Data;
    std::unique_ptr<const Data> data_;
};

}  // namespace relief::mesh
