#pragma once

#include <vector>

#include "relief/multires/mesh_lift.h"

namespace relief::multires {

/// P^T P of a step over its inner vertices: the smooth ones and darts, others being zero. It is
/// applied on the coarse mesh alone: with
///     g = self c + ring (sum of neighbours)
/// the row of P for an old vertex, what old vertices add to P^T P c is g, gathered once more; what
/// new ones add depends on the neighbours and, Loop, on the vertices across the edges opposite.
/// Catmull-Clark goes through the points of faces; but where all is regular P^T P is the square in
/// both directions of that of cubic curves, and so a product of two sums over the eight vertices
/// around. Where creases end inside the surface `terms_` and `dart_edges_` mend what this supposes.
///
/// Inner vertices are counted in the order in which faces name them: so neighbours are near each
/// other in memory. Every element is gathered in an order of its own: results do not depend on the
/// number of threads. Source: performance.md section 4.3.
class MeshNormal {
  public:
    using Points = Buffer<Vec3<double>>;
    /// Memory of the functions below, kept between them. A last element is zero: all vertices that
    /// are not inner.
    struct Passes {
        explicit Passes(const MeshNormal& normal);

        Points image;
        Points spread;    ///< what a vertex gives to its ring
        Points faces;     ///< Catmull-Clark: their points
        Points shares;    ///< and what they give to their corners
        Points smoothed;  ///< Catmull-Clark, regular vertices: the first of both sums
    };

    /// Complexity: O(n).
    explicit MeshNormal(const MeshStep<double>& step);

    /// The inner vertices in their order here.
    [[nodiscard]] std::size_t size() const { return vertices_.size(); }
    [[nodiscard]] const Buffer<mesh::Index>& vertices() const { return vertices_; }

    /// P^T (old, fresh) over the inner vertices.
    [[nodiscard]] Points adjoint(const Vec3<double>* old, const Vec3<double>* fresh,
                                 Passes& passes) const;

    /// The sums of the columns of P.
    [[nodiscard]] Points column_sums() const;

    /// y = P^T P x.
    void apply(const Vec3<double>* x, Vec3<double>* y, Passes& passes) const;

    /// Sweeps of section 7.2 from 0 towards P^T P x = target. scale: 1 / column sums of P.
    [[nodiscard]] Points sweep(const LiftOptions& options, const std::vector<double>& scale,
                               const Points& target, Passes& passes) const;

  private:
    /// y[row] += weight x[column].
    struct Term {
        mesh::Index row = 0;
        mesh::Index column = 0;
        double weight = 0;
    };
    /// Catmull-Clark: a sharp edge of a dart.
    struct DartEdge {
        std::array<mesh::Index, 2> ends{};
        std::array<mesh::Index, 2> faces{};
    };
    /// By valence. The neighbours of Catmull-Clark vertices count with the points of faces; the new
    /// vertices of edges or faces add `own` c.
    struct Row {
        double self = 0;
        double ring = 0;
        double own = 0;
    };
    void count_vertices();
    void list_rings();
    void list_rows();
    void list_regular();
    void list_rest();
    void mend_triangles();
    void mend_darts();
    void add_square(std::initializer_list<mesh::Index> vertices, double weight);
    [[nodiscard]] const Row& row_of(mesh::Index v) const {
        return rows_[first_[v + 1] - first_[v]];
    }

    template <class Fresh>
    void from_fresh(Fresh fresh, Passes& passes) const;
    template <class Old, class Fresh>
    [[nodiscard]] Points adjoint_of(Old old, Fresh fresh, Passes& passes) const;
    void through_rings(const Vec3<double>* x, Passes& passes) const;
    template <mesh::Index Sides>
    void to_faces(const Vec3<double>* x, Passes& passes) const;
    void sum_regular(const Vec3<double>* x, Passes& passes) const;
    void through_quad_rings(const Vec3<double>* x, Passes& passes) const;
    template <mesh::Index Sides>
    void from_faces(const Vec3<double>* x, Passes& passes) const;
    [[nodiscard]] Vec3<double> from_ring(mesh::Index v, const Passes& passes) const;
    template <class Finish>
    void images(const Vec3<double>* x, Passes& passes, Finish finish) const;

    const mesh::Topology& mesh_;
    const StepRules& rules_;
    Buffer<mesh::Index> vertices_;
    Buffer<mesh::Index> place_;   ///< [vertex of the mesh]: among the inner ones
    Buffer<mesh::Index> first_;   ///< of its ring
    Buffer<mesh::Index> ring_;    ///< places of neighbours
    Buffer<mesh::Index> across_;  ///< Loop: of vertices across the edges opposite; Catmull-Clark:
                                  ///< faces
    /// Catmull-Clark. Regular: with four quads around; Deep: all eight vertices around are regular.
    enum class Place : std::uint8_t { Irregular, Regular, Deep };
    Buffer<Place> regular_;
    Buffer<mesh::Index> diagonal_;          ///< places across the quads
    std::vector<mesh::Index> rest_faces_;   ///< that vertices need which are not deep: points,
    std::vector<mesh::Index> rest_shares_;  ///< shares,
    std::vector<mesh::Index> rest_rings_;   ///< and what they give to the ring
    std::vector<Row> rows_;                 ///< [valence]
    double near_ = 0;                       ///< triangles: what new vertices add for each neighbour
    double far_ = 0;                        ///< Loop: for each vertex across
    std::vector<Term> terms_;
    std::vector<DartEdge> dart_edges_;
    std::vector<std::array<mesh::Index, 2>> creases_;  ///< vertices, and the places of darts beside
};

}  // namespace relief::multires
