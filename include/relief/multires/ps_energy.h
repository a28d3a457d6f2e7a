#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "relief/multires/ps_space.h"

/// Integrals of Powell-Sabin splines: L2 products and energies, exact up to rounding. Source:
/// powell-sabin.md section 11; docs/powell-sabin.md.
namespace relief::multires::ps {

/// A symmetric matrix of all B-splines, by blocks: entry (3i + j, 3k + l) is number 3j + l of the
/// block of vertices i and k, which are equal or coupled.
struct BlockMatrix {
    using Block = std::array<double, 9>;

    BlockMatrix() = default;
    /// Zero; `coupled` are the vertices of each row but its own, ascending.
    explicit BlockMatrix(const mesh::VertexStars& coupled);

    std::vector<std::size_t> first;   ///< row i has entries first[i] .. first[i + 1] - 1
    std::vector<mesh::Index> column;  ///< ascending in each row
    std::vector<Block> block;

    [[nodiscard]] std::size_t rows() const { return first.size() - 1; }
    [[nodiscard]] std::span<const mesh::Index> columns(mesh::Index row) const {
        return {column.data() + first[row], first[row + 1] - first[row]};
    }
    /// The block of two vertices; nullptr if it is zero.
    [[nodiscard]] const Block* find(mesh::Index row, mesh::Index col) const;
    /// Requires: equal or coupled vertices.
    [[nodiscard]] Block& at(mesh::Index row, mesh::Index col);
    /// Adds a matrix of the nine B-splines of three vertices that are coupled.
    void add(const std::array<mesh::Index, 3>& vertices, const spline::PsMatrix& element);
    /// The product with coefficients. Requires: one element a row.
    [[nodiscard]] Coefficients times(std::span<const Heights> spline) const;
};

/// Integrals of products of B-splines; of s_xx t_xx + 2 s_xy t_xy + s_yy t_yy. Vertices are coupled
/// by edges. Complexity: O(n); memory: about 500 bytes a vertex.
[[nodiscard]] BlockMatrix gram_matrix(const Space& space);
[[nodiscard]] BlockMatrix thin_plate_matrix(const Space& space);
/// jump_energy as a quadratic form. Vertices are coupled by edges, and across them. Complexity: O(n
/// log n), one thread.
[[nodiscard]] BlockMatrix jump_matrix(const Space& space);
/// The vertices of each vertex's edges, and those on the other sides of the edges opposite it.
[[nodiscard]] mesh::VertexStars jump_coupling(const mesh::Triangulation& mesh);

/// The integral of s_xx^2 + 2 s_xy^2 + s_yy^2, in squared value units per squared coordinate unit;
/// 0 for planes. Requires: a checked spline.
[[nodiscard]] double thin_plate_energy(const Space& space, std::span<const Heights> spline);
/// The sum over all segments in the domain across which the Hessian jumps of (length x jump)^2, in
/// the same unit; 0 for quadratics. Requires: a checked spline.
[[nodiscard]] double jump_energy(const Space& space, std::span<const Heights> spline);

/// Integrals of a function, and of it times x and y relative to its own vertex.
struct Moments {
    double mass = 0;
    Vec2 first;
};
/// Of the three B-splines of each vertex, from the Gram matrix of the space.
[[nodiscard]] std::vector<std::array<Moments, 3>> moments(const Space& space,
                                                          const BlockMatrix& gram);

}  // namespace relief::multires::ps
