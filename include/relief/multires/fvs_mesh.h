#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "relief/core/result.h"
#include "relief/mesh/locate.h"
#include "relief/mesh/quadrangulation.h"
#include "relief/spline/fvs_element.h"

/// Scheme `fvs` on quadrangulations of the plane: C1 cubic splines on a nested sequence of meshes
/// with the hierarchical basis of Hong and Schumaker. Level 0 is the given mesh, level m its m-th
/// refinement (the raster schemes count the other way). Source: fvs-hierarchical.md sections 4, 6
/// and 8 to 10; docs/fvs.md. Sums have a fixed order, so that results are the same for any number
/// of threads.
namespace relief::multires::fvs_mesh {

/// The meshes of levels 0 .. levels(), and the point location of the coarsest.
class Hierarchy {
  public:
    /// Errors: `level_out_of_range` as mesh::level_counts. Complexity: O(size of the finest mesh),
    /// which grows by 4 a level: whoever reads `levels` from a file first compares
    /// mesh::level_counts with what the file holds.
    [[nodiscard]] static Result<Hierarchy> create(mesh::Quadrangulation base, int levels);

    [[nodiscard]] int levels() const { return static_cast<int>(meshes_.size()) - 1; }
    [[nodiscard]] const mesh::Quadrangulation& mesh(int level) const {
        return meshes_[static_cast<std::size_t>(level)];
    }
    [[nodiscard]] const mesh::Locator& locator() const { return locator_; }

  private:
    explicit Hierarchy(std::vector<mesh::Quadrangulation> meshes)
        : meshes_(std::move(meshes)), locator_(meshes_.front()) {}
    std::vector<mesh::Quadrangulation> meshes_;
    mesh::Locator locator_;  ///< refers to the first mesh, which does not move with the vector
};

/// Numbers of one level: at its vertices values and gradients, at the midpoints of its edges the
/// derivative along the normal, which is the edge's direction turned by +90 degrees. Derivatives
/// are true ones, in value units per coordinate unit. T: double, or int for quantised numbers.
template <class T>
struct Nodal {
    std::vector<T> value;   ///< V
    std::vector<T> dx;      ///< V
    std::vector<T> dy;      ///< V
    std::vector<T> normal;  ///< E

    friend bool operator==(const Nodal&, const Nodal&) = default;
};
/// A spline of a level.
using NodalData = Nodal<double>;

/// What level m has that its parent level has not: of V, E, Q elements of the parent level.
template <class T>
struct Details {
    std::vector<T> edge_value;       ///< E: value at the midpoint
    std::vector<T> edge_tangential;  ///< E: derivative along the edge at the midpoint
    std::vector<T> centre_value;     ///< Q: value at c
    std::vector<T> centre_dx;        ///< Q
    std::vector<T> centre_dy;        ///< Q
    std::vector<T> normal;           ///< 2E + 4Q: normal derivatives of the edges of level m

    friend bool operator==(const Details&, const Details&) = default;
};

/// A spline in the hierarchical basis; details[m - 1] are those of level m. Every prefix of levels
/// is a C1 spline.
struct Decomposition {
    NodalData base;
    std::vector<Details<double>> details;
};

/// The spline of a level's mesh that interpolates a function. f gets points in the coordinates of
/// the mesh's source and gives value and gradient.
[[nodiscard]] NodalData interpolate(const mesh::Quadrangulation& mesh,
                                    const std::function<spline::PlaneJet(Vec2)>& f);

/// The same from values at the vertices alone. A quadratic through each vertex is fitted to its
/// neighbours by least squares with weights 1 / distance^2: to the vertices of its quads (1-ring)
/// or, where these do not determine it, to those of the quads around them too (2-ring), else a
/// linear function to the 1-ring. Its gradient is that of the vertex; normal derivatives are means
/// over the quadratics of an edge's ends, at its midpoint. Exact for quadratics if every 2-ring
/// determines one. Errors: `size_mismatch`, `non_finite_data`. Complexity: O(n).
[[nodiscard]] Result<NodalData> interpolate_values(const mesh::Quadrangulation& mesh,
                                                   std::span<const double> values);

/// The quadratic through a vertex that interpolate_values fits there: value + gradient . d + (xx
/// dx^2 + 2 xy dx dy + yy dy^2) / 2, d being the way from the vertex.
struct VertexQuadratic {
    Vec2 gradient;
    double xx = 0;
    double xy = 0;
    double yy = 0;

    [[nodiscard]] Vec2 gradient_at(Vec2 d) const {
        return {gradient.x + xx * d.x + xy * d.y, gradient.y + xy * d.x + yy * d.y};
    }
    friend bool operator==(const VertexQuadratic&, const VertexQuadratic&) = default;
};

/// How the quadratic of a vertex follows from values: of each vertex around, what a rise of 1 above
/// the vertex itself adds.
struct QuadraticRule {
    struct Share {
        mesh::Index vertex = 0;
        VertexQuadratic quadratic;
    };
    std::vector<Share> shares;

    /// Complexity: O(shares); 9 operations for each.
    [[nodiscard]] VertexQuadratic apply(std::span<const double> values, mesh::Index v) const;
};

/// The parts of interpolate_values one by one: for values of which few change. Immutable; several
/// threads may ask.
class LocalInterpolation {
  public:
    /// The mesh must outlive this and keep its address. Complexity: O(n).
    explicit LocalInterpolation(const mesh::Quadrangulation& mesh)
        : mesh_(&mesh), quads_(mesh::vertex_quads(mesh)) {}

    /// To the bit that of interpolate_values; it depends on values of the 2-ring at most. Requires:
    /// a value for each vertex, finite.
    [[nodiscard]] VertexQuadratic quadratic(std::span<const double> values, mesh::Index v) const;
    /// The same up to rounding, for many values: it depends on the mesh alone.
    [[nodiscard]] QuadraticRule rule(mesh::Index v) const;
    /// The normal derivative at the middle of an edge from the quadratics of its ends.
    [[nodiscard]] double normal(mesh::Index e, const VertexQuadratic& from,
                                const VertexQuadratic& to) const;

  private:
    const mesh::Quadrangulation* mesh_;
    mesh::VertexQuads quads_;
};

/// `size_mismatch` or `non_finite_data` (also beyond 1e150, where squares overflow), if there is
/// such an error.
[[nodiscard]] Status check(const mesh::Quadrangulation& mesh, const NodalData& data);

/// The same spline on the refined mesh (section 4). Requires: checked data.
[[nodiscard]] NodalData predict(const mesh::Quadrangulation& parent, const NodalData& low);

/// The spline of the parent level that interpolates one of the refined mesh. Requires: checked
/// data.
[[nodiscard]] NodalData restrict_to(const mesh::Quadrangulation& parent, const NodalData& fine);

/// The spline of the finest level to its hierarchical coefficients. Errors: those of check.
/// Complexity: O(n).
[[nodiscard]] Result<Decomposition> decompose(const Hierarchy& hierarchy, NodalData finest);

/// The spline of `level` from its coefficients and those below, the inverse of decompose up to
/// rounding. Errors: `level_out_of_range`, `size_mismatch`, `non_finite_data`. Complexity: O(n).
[[nodiscard]] Result<NodalData> reconstruct(const Hierarchy& hierarchy,
                                            const Decomposition& coefficients, int level);

/// Limits of section 6: epsilon for values, epsilon W for derivatives, h being the length of the
/// level-m edge for a normal derivative, half the parent edge's for a tangential one, root of the
/// parent quad's area over 2 at a centre.
enum class Convention {
    Text,   ///< W = 1 / h: the algorithm as printed (2^m on the unit square)
    Const,  ///< W = 2^(l - m) / h: the paper's own numbers (2^l on the unit square)
};
/// Limits for the details of levels 1 .. levels().
[[nodiscard]] std::vector<Details<double>> threshold_limits(const Hierarchy& hierarchy,
                                                            double epsilon, Convention convention);

/// Sets details whose absolute value is below their limit to zero. Level 0 stays. Returns how many
/// numbers were kept, of level 0, 1, ..  Requires: sizes agree.
std::vector<std::uint64_t> threshold(Decomposition& coefficients,
                                     const std::vector<Details<double>>& limits);

enum class Outside {
    Reject,  ///< a point outside the domain or in a hole is an error
    Clamp,   ///< it is moved to the nearest point of the boundary
};

/// The quad of a level's mesh that contains a point, or nothing outside.
[[nodiscard]] std::optional<mesh::Place> locate(const Hierarchy& hierarchy, int level, Vec2 point,
                                                Outside outside = Outside::Reject);

/// Value, gradient and Hessian of a spline of `level` at points in the coordinates of the mesh's
/// source. On edges the Hessian is that of the quad of the smallest number, and in a quad that of
/// FvsElement::triangle_of. Errors: `level_out_of_range`, `size_mismatch`, `outside_domain` naming
/// the first such point, also for one that is not finite. Complexity: O(log n) a point, in
/// parallel.
[[nodiscard]] Status evaluate(const Hierarchy& hierarchy, int level, const NodalData& data,
                              std::span<const Vec2> points, std::span<spline::PlaneJet> out,
                              Outside outside = Outside::Reject);

/// Root of the integral of the squared spline. Requires: checked data.
[[nodiscard]] double l2_norm(const mesh::Quadrangulation& mesh, const NodalData& data);

/// For every quad an upper bound of the spline's absolute value: its largest Bezier ordinate after
/// `refinements` further refinements (section 8.1); infinite where ordinates overflow. Requires:
/// checked data. Complexity: O(4^refinements) a quad, in parallel.
[[nodiscard]] std::vector<double> quad_bounds(const mesh::Quadrangulation& mesh,
                                              const NodalData& data, int refinements);

/// An upper bound of |a - b| on the whole domain, rounding included (1e-13 of the larger surface).
[[nodiscard]] double error_bound(const mesh::Quadrangulation& mesh, const NodalData& a,
                                 const NodalData& b, int refinements);

}  // namespace relief::multires::fvs_mesh
