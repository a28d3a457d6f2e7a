#pragma once

#include <vector>

#include "relief/multires/mesh_lift.h"

namespace relief::multires {

/// P^T P of a step over its inner vertices: the smooth ones and darts, others being zero. It is
/// applied on the coarse mesh alone: for triangles its rows reach two rings, of which
///     g = self c + ring (sum of neighbours)
/// is the row of P for an old vertex, and what new vertices add depends on the neighbours, and for
/// Loop on the vertices across the edges opposite (`across`). Catmull-Clark goes through the points
/// of faces. Where creases end inside the surface `terms_` and `dart_edges_` mend what this
/// supposes. Every element is gathered in an order of its own, so that results do not depend on the
/// number of threads. Source: performance.md section 4.3.
class MeshNormal {
  public:
    using Points = Buffer<Vec3<double>>;

    /// Complexity: O(n).
    explicit MeshNormal(const MeshStep<double>& step);

    /// y = P^T P x. Requires: x is zero at other vertices, and so is y.
    void apply(const Vec3<double>* x, Vec3<double>* y) const;

    /// Sweeps of section 7.2 from 0 towards P^T P x = target: out at inner vertices, others are
    /// left alone. scale: 1 / column sums of P.
    void sweep(const LiftOptions& options, const double* scale, const Vec3<double>* target,
               Vec3<double>* out) const;

  private:
    /// y[row] += weight x[column].
    struct Term {
        mesh::Index row = 0;
        mesh::Index column = 0;
        double weight = 0;
    };
    /// A sharp edge with a dart: Catmull-Clark.
    struct DartEdge {
        std::array<mesh::Index, 2> ends{};
        std::array<mesh::Index, 2> faces{};
    };
    /// By valence. g = self c + ring (sum of neighbours, and of face points for Catmull-Clark); the
    /// new vertices of edges or faces at c add `own` c to its row of P^T P.
    struct Row {
        double self = 0;
        double ring = 0;
        double own = 0;
    };
    /// What is kept between the passes.
    struct Scratch {
        Points image;
        Points spread;  ///< what an inner vertex gives to its ring
        Points faces;   ///< Catmull-Clark: points, and what faces give to their corners
        Points shares;
    };

    void list_rings(const MeshStep<double>& step);
    void list_rows(const MeshStep<double>& step);
    void mend_triangles(const MeshStep<double>& step);
    void mend_darts(const MeshStep<double>& step);
    void add_square(std::initializer_list<mesh::Index> vertices, double weight);
    [[nodiscard]] bool is_inner(mesh::Index v) const { return first_[v] != first_[v + 1]; }
    [[nodiscard]] Scratch scratch() const;

    void to_rings(const Vec3<double>* x, Scratch& scratch) const;
    void to_faces(const Vec3<double>* x, Scratch& scratch) const;
    void from_faces(const Vec3<double>* x, Scratch& scratch) const;
    void to_quad_rings(const Vec3<double>* x, Scratch& scratch) const;
    template <class Finish>
    void images(const Vec3<double>* x, Scratch& scratch, Finish finish) const;

    const mesh::Topology& mesh_;
    const StepRules& rules_;
    Buffer<mesh::Index> first_;   ///< [vertex]: of its ring; none of others than inner vertices
    Buffer<mesh::Index> ring_;    ///< its neighbours
    Buffer<mesh::Index> across_;  ///< Loop: the vertex across the edge behind; Catmull-Clark: faces
    std::vector<Row> rows_;       ///< [valence]
    double near_ = 0;             ///< triangles: new vertices' part of P^T P for each neighbour
    double far_ = 0;              ///< Loop: for each vertex across
    std::vector<Term> terms_;
    std::vector<DartEdge> dart_edges_;
};

}  // namespace relief::multires
