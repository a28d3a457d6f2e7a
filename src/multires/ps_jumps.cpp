#include <algorithm>
#include <numeric>

#include "multires/ps_triangles.h"
#include "relief/multires/ps_energy.h"

/// The jump energy as a quadratic form.
namespace relief::multires::ps {

using mesh::Index;
using spline::Hessian;
using spline::PsPolynomials;

namespace {

/// The corner of triangle t that lies opposite its edge e.
Index opposite(const mesh::Triangulation& mesh, Index t, Index e) {
    return mesh.triangles[t][(side_of(mesh, t, e) + 2) % 3];
}

double second_derivative(const Hessian& h, Vec2 n) {
    return n.x * n.x * h.xx + 2 * n.x * n.y * h.xy + n.y * n.y * h.yy;
}

/// The jump of the second derivative across a segment, times its length, as weights of the
/// coefficients of the vertices around.
class Jump {
  public:
    Jump(const Space& space, Vec2 along)
        : space_(space), normal_(turned(unit(along))), length_(length(along)) {}

    /// Adds the second derivative of a piece of triangle t; the sign tells its side.
    void add(Index t, const BasisPolynomials& basis, int piece, double sign) {
        for (std::size_t i = 0; i < 9; ++i)
            weights_of(space_.mesh.triangles[t][i / 3])[i % 3] +=
                sign * length_ *
                second_derivative(basis[i].hessian[static_cast<std::size_t>(piece)], normal_);
    }

    /// Adds the jump's square.
    void add_square_to(BlockMatrix& matrix) const {
        for (std::size_t a = 0; a < count_; ++a)
            for (std::size_t b = 0; b < count_; ++b) {
                BlockMatrix::Block& block = matrix.at(vertices_[a], vertices_[b]);
                for (std::size_t j = 0; j < 3; ++j)
                    for (std::size_t l = 0; l < 3; ++l)
                        block[3 * j + l] += weights_[a][j] * weights_[b][l];
            }
    }

  private:
    Heights& weights_of(Index v) {
        const auto end = vertices_.begin() + static_cast<std::ptrdiff_t>(count_);
        const auto place =
            static_cast<std::size_t>(std::find(vertices_.begin(), end, v) - vertices_.begin());
        if (place == count_) vertices_[count_++] = v;
        return weights_[place];
    }

    const Space& space_;
    Vec2 normal_;
    double length_;
    std::array<Index, 4> vertices_{};  ///< of the two triangles beside
    std::array<Heights, 4> weights_{};
    std::size_t count_ = 0;
};

}  // namespace

mesh::VertexStars jump_coupling(const mesh::Triangulation& mesh) {
    std::vector<std::array<Index, 2>> pairs;
    const auto couple = [&](Index a, Index b) {
        pairs.push_back({a, b});
        pairs.push_back({b, a});
    };
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        couple(mesh.edges[e][0], mesh.edges[e][1]);
        if (mesh.on_boundary(e)) continue;
        const auto [left, right] = mesh.edge_triangles[e];
        couple(opposite(mesh, left, e), opposite(mesh, right, e));
    }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    mesh::VertexStars coupled;
    coupled.first.assign(mesh.vertex_count() + std::size_t{1}, 0);
    for (const auto& [v, other] : pairs) {
        ++coupled.first[v + 1];
        coupled.items.push_back(other);
    }
    std::partial_sum(coupled.first.begin(), coupled.first.end(), coupled.first.begin());
    return coupled;
}

BlockMatrix jump_matrix(const Space& space) {
    const mesh::Triangulation& mesh = space.mesh;
    BlockMatrix matrix(jump_coupling(mesh));
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const auto basis = basis_polynomials(space, t);
        const spline::PsElement element = space.element(t);
        const auto add_spoke = [&](Vec2 end, int before, int after) {
            Jump jump(space, end);
            jump.add(t, basis, before, 1);
            jump.add(t, basis, after, -1);
            jump.add_square_to(matrix);
        };
        for (int k = 0; k < 3; ++k) {
            add_spoke(element.edge_point(k), 2 * k, 2 * k + 1);
            add_spoke(element.corner(k), (2 * k + 5) % 6, 2 * k);
        }
    }
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        if (mesh.on_boundary(e)) continue;
        const auto [left, right] = mesh.edge_triangles[e];
        const auto here = pieces_at(mesh, left, e);
        const auto there = pieces_at(mesh, right, e);
        const auto basis_left = basis_polynomials(space, left);
        const auto basis_right = basis_polynomials(space, right);
        const Vec2 middle = edge_point(mesh, space.split, e);
        for (std::size_t end = 0; end < 2; ++end) {
            Jump jump(space, middle - mesh.vertex(mesh.edges[e][end]));
            jump.add(left, basis_left, here[end], 1);
            jump.add(right, basis_right, there[end], -1);
            jump.add_square_to(matrix);
        }
    }
    return matrix;
}

}  // namespace relief::multires::ps
