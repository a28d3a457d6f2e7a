#include "relief/core/block_cholesky.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support.h"

namespace relief {
namespace {

/// A side x side lattice, each point joined to its eight neighbours.
struct Lattice {
    std::vector<Vec2> points;
    std::vector<std::uint32_t> first{0};
    std::vector<std::uint32_t> items;

    explicit Lattice(int side) {
        for (int r = 0; r < side; ++r)
            for (int c = 0; c < side; ++c) {
                points.push_back({double(c), double(r)});
                for (int dr = -1; dr <= 1; ++dr)
                    for (int dc = -1; dc <= 1; ++dc) {
                        const bool inside =
                            r + dr >= 0 && r + dr < side && c + dc >= 0 && c + dc < side;
                        if (inside && (dr != 0 || dc != 0))
                            items.push_back(std::uint32_t((r + dr) * side + c + dc));
                    }
                first.push_back(std::uint32_t(items.size()));
            }
    }
    [[nodiscard]] GraphView graph() const { return {first, items}; }
};

/// Random and diagonally dominant: positive definite.
struct Matrix {
    std::vector<Block3> diagonal;
    std::vector<Block3> off;

    explicit Matrix(const GraphView& graph) : diagonal(graph.size()), off(graph.items.size()) {
        test::Noise noise(3);
        for (std::uint32_t v = 0; v < graph.size(); ++v)
            for (std::uint32_t n = graph.first[v]; n < graph.first[v + 1]; ++n) {
                const std::uint32_t w = graph.items[n];
                if (w < v) continue;
                for (double& x : off[n]) x = noise();
                const auto back = std::find(graph.of(w).begin(), graph.of(w).end(), v);
                Block3& mirror = off[graph.first[w] + std::uint32_t(back - graph.of(w).begin())];
                for (std::size_t i = 0; i < 3; ++i)
                    for (std::size_t j = 0; j < 3; ++j) mirror[3 * j + i] = off[n][3 * i + j];
            }
        for (Block3& block : diagonal) block = {30, 1, 2, 1, 28, -3, 2, -3, 27};
    }

    [[nodiscard]] std::vector<Column3> times(const GraphView& graph,
                                             const std::vector<Column3>& x) const {
        std::vector<Column3> y(x.size(), Column3{});
        const auto add = [](Column3& sum, const Block3& a, const Column3& z) {
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = 0; j < 3; ++j) sum[i] += a[3 * i + j] * z[j];
        };
        for (std::uint32_t v = 0; v < graph.size(); ++v) {
            add(y[v], diagonal[v], x[v]);
            for (std::uint32_t n = graph.first[v]; n < graph.first[v + 1]; ++n)
                add(y[v], off[n], x[graph.items[n]]);
        }
        return y;
    }
};

TEST(BlockCholesky, SolvesInAnyOrder) {
    for (const int side : {1, 2, 5, 23}) {
        const Lattice lattice(side);
        const GraphView graph = lattice.graph();
        const Matrix matrix(graph);
        std::vector<Column3> expected(graph.size());
        test::Noise noise(5);
        for (Column3& x : expected) x = {noise(), noise(), noise()};
        std::vector<std::uint32_t> given(graph.size());
        std::iota(given.begin(), given.end(), 0U);
        for (const auto& order : {given, nested_dissection(lattice.points, graph)}) {
            BlockCholesky solver(graph, order);
            ASSERT_EQ(solver.factor(graph, matrix.diagonal, matrix.off), graph.size());
            auto x = matrix.times(graph, expected);
            solver.solve(x);
            for (std::size_t v = 0; v < x.size(); ++v)
                for (std::size_t i = 0; i < 3; ++i)
                    EXPECT_NEAR(x[v][i], expected[v][i], 1e-12) << side;  // a condition of about 20
        }
    }
}

TEST(BlockCholesky, DissectionIsAPermutationThatSavesBlocks) {
    const Lattice lattice(60);
    const GraphView graph = lattice.graph();
    const auto order = nested_dissection(lattice.points, graph);
    auto sorted = order;
    std::sort(sorted.begin(), sorted.end());
    std::vector<std::uint32_t> given(graph.size());
    std::iota(given.begin(), given.end(), 0U);
    EXPECT_EQ(sorted, given);
    // Row by row a band of 61 blocks; dissection needs about log2(3600) x 31 / 8.
    EXPECT_LT(BlockCholesky(graph, order).factor_blocks(), 60 * 60 * 40U);
    EXPECT_GT(BlockCholesky(graph, given).factor_blocks(), 60 * 60 * 58U);
}

TEST(BlockCholesky, NamesWhereTheMatrixIsSingular) {
    const Lattice lattice(4);
    const GraphView graph = lattice.graph();
    Matrix matrix(graph);
    for (Block3& block : matrix.off) block = {};
    matrix.diagonal[6] = {1, 1, 0, 1, 1, 0, 0, 0, 1};
    BlockCholesky solver(graph, nested_dissection(lattice.points, graph));
    EXPECT_EQ(solver.factor(graph, matrix.diagonal, matrix.off), 6U);
}

}  // namespace
}  // namespace relief
