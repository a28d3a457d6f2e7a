#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "relief/core/vec2.h"

/// Large sparse symmetric positive definite matrices of 3 x 3 blocks, one row of blocks for each
/// vertex of a graph in the plane. The same bits on every machine.
namespace relief {

/// The neighbours of each vertex: those of vertex v are items[first[v]] .. items[first[v + 1] - 1].
struct GraphView {
    std::span<const std::uint32_t> first;
    std::span<const std::uint32_t> items;

    [[nodiscard]] std::uint32_t size() const {
        return static_cast<std::uint32_t>(first.size() - 1);
    }
    [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t v) const {
        return items.subspan(first[v], first[v + 1] - first[v]);
    }
};

/// An order of elimination in which factors stay sparse: vertices are halved across the longer side
/// of their bounding box again and again; those of one half with neighbours in the other come last.
/// Requires: a symmetric graph. Complexity: O(n log n).
[[nodiscard]] std::vector<std::uint32_t> nested_dissection(std::span<const Vec2> points,
                                                           const GraphView& graph);

using Block3 = std::array<double, 9>;  ///< row by row
using Column3 = std::array<double, 3>;

/// What becomes of pivots of which rounding left not more than 1e-13 of the matrix' own element.
enum class LostPivots {
    Refuse,  ///< the matrix is singular
    Raise,   ///< to 1e-8 of that element: the unknown follows those after it. For matrices that are
             ///< known to be positive definite.
};

/// The factors L L^T of a matrix whose block (v, w) is zero unless v = w or v and w are
/// neighbours. For planar graphs in the order of nested dissection they have O(n log n) blocks, and
/// factoring takes O(n^1.5).
class BlockCholesky {
  public:
    /// Where factors have blocks: the same for all matrices of a graph. order[k] is the vertex that
    /// is eliminated as the k-th.
    BlockCholesky(const GraphView& graph, std::vector<std::uint32_t> order);

    [[nodiscard]] std::size_t size() const { return order_.size(); }
    [[nodiscard]] std::size_t factor_blocks() const { return rows_.size(); }

    /// diagonal[v] is block (v, v); off_diagonal[k] is block (v, items[k]) for the k-th neighbour
    /// in the graph, of which those with the later vertex in the order as v are read.
    /// Returns the vertex whose pivot was lost and refused, or size().
    [[nodiscard]] std::size_t factor(const GraphView& graph, std::span<const Block3> diagonal,
                                     std::span<const Block3> off_diagonal,
                                     LostPivots lost = LostPivots::Refuse);

    /// x = A^-1 x in place, x[v] being the three numbers of vertex v. Requires: factored.
    void solve(std::span<Column3> x) const;

  private:
    void find_pattern(const GraphView& graph);

    std::vector<std::uint32_t> order_;
    std::vector<std::uint32_t> place_;   ///< of each vertex in the order
    std::vector<std::uint32_t> parent_;  ///< elimination tree, in places
    std::vector<std::uint64_t> first_;   ///< of each column among rows_
    std::vector<std::uint32_t> rows_;    ///< places below the diagonal, ascending
    std::vector<Block3> lower_;          ///< L, parallel to rows_
    std::vector<Block3> root_;           ///< diagonal blocks of L, their diagonals inverted
};

}  // namespace relief
