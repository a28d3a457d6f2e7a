#pragma once

#include <cstdint>
#include <span>

#include "relief/core/buffer.h"
#include "relief/core/grid.h"
#include "relief/core/vec3.h"
#include "relief/mesh/triangle_locator.h"
#include "relief/multires/ps_space.h"

/// Evaluation of Powell-Sabin splines of one to three components. Source: powell-sabin.md section
/// 10; docs/powell-sabin.md.
namespace relief::multires::ps {

/// Splines that share a space, ready to be evaluated. Each triangle has its geometry and, for each
/// component, value and gradient at Z and the Hessians of the six pieces in one block: 256 bytes
/// for one component, of which a point needs four lines of cache. Immutable; several threads may
/// ask.
class Surface {
  public:
    /// The triangles of the mesh must outlive the surface and keep their address; its edges, the
    /// split and the control triangles need not. Errors: those of `check`, and `component_count`
    /// unless there are one to three. Complexity: O(n).
    [[nodiscard]] static Result<Surface> create(const Space& space,
                                                std::span<const Coefficients> components);
    /// The same from the tangent planes at the vertices, without control triangles.
    [[nodiscard]] static Result<Surface> create(const mesh::Triangulation& mesh, const Split& split,
                                                std::span<const TangentPlanes> components);

    [[nodiscard]] const mesh::PlaneTriangles& triangles() const { return *triangles_; }
    /// The triangles have moved to another address.
    void follow(const mesh::PlaneTriangles& triangles) { triangles_ = &triangles; }
    [[nodiscard]] int components() const { return components_; }

    /// Value, gradient and Hessian in a triangle, at a point relative to the mesh's origin. Value
    /// and gradient are continuous; the Hessian jumps between pieces and is that of the piece
    /// following the point counter-clockwise around Z. Complexity: O(1).
    [[nodiscard]] spline::PlaneJet jet(mesh::Index triangle, Vec2 point, int component = 0) const;
    /// The same for all components, into components() elements.
    void jets(mesh::Index triangle, Vec2 point, spline::PlaneJet* out) const;

    /// The numbers of a triangle, for this library's own loops.
    [[nodiscard]] const double* numbers(mesh::Index triangle) const {
        return blocks_.data() + static_cast<std::size_t>(triangle) * stride_;
    }

  private:
    Surface(const mesh::PlaneTriangles& triangles, int components);
    static Result<Surface> made(const mesh::Triangulation& mesh, const Split& split,
                                std::span<const TangentPlanes> components);

    const mesh::PlaneTriangles* triangles_;
    int components_;
    std::size_t stride_;
    Buffer<double> blocks_;
};

/// What becomes of points outside the domain, or in a hole.
enum class Outside {
    Reject,   ///< an error
    Nan,      ///< all numbers of their jets are NaN
    Nearest,  ///< they are moved to the nearest point of the boundary
};

/// Jets at points in the coordinates of the mesh's source; that of component m at point k goes to
/// out[k * components() + m]. Results do not depend on the order of points. The locator is that of
/// the surface's mesh. Errors: `size_mismatch`; `outside_domain` (Reject), `non_finite_point`
/// (Nearest), both for the first such point. Complexity: O(1) a point; many are visited in an order
/// in which neighbours follow each other.
[[nodiscard]] Status evaluate(const Surface& surface, const mesh::TriangleLocator& locator,
                              std::span<const Vec2> points, std::span<spline::PlaneJet> out,
                              Outside outside = Outside::Reject);

/// Where the samples of a raster lie: that of row r, column c at first + (c step.x, r step.y), in
/// the coordinates of the mesh's source.
struct RasterFrame {
    Vec2 first;
    Vec2 step{1, 1};  ///< not 0; y may be negative
};

/// The values of a component at the samples of a raster, triangle by triangle along its rows. A
/// sample on an edge belongs to the triangle of the smallest number. Outside as for `evaluate`;
/// only Nearest needs the locator. Errors: `invalid_frame` (steps not positive in x, zero
/// in y, not finite, or lost in the digits of the coordinates), `component_count`,
/// `missing_locator` (Nearest), `outside_domain`. Complexity: O(samples + n).
[[nodiscard]] Status evaluate_raster(const Surface& surface, const RasterFrame& frame,
                                     GridView<double> out, int component = 0,
                                     Outside outside = Outside::Nan,
                                     const mesh::TriangleLocator* locator = nullptr);

/// The unit normal of the graph of a function, upwards.
[[nodiscard]] Vec3<double> graph_normal(const spline::PlaneJet& jet);

/// The unit normal X_u x X_v of a parametric surface from the jets of x, y and z. NaN where X_u and
/// X_v are parallel to 1e-14.
[[nodiscard]] Vec3<double> parametric_normal(std::span<const spline::PlaneJet, 3> jets);

}  // namespace relief::multires::ps
