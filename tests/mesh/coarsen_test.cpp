#include "relief/mesh/coarsen.h"

#include <algorithm>
#include <numeric>
#include <random>

#include "mesh/meshes.h"

namespace relief::mesh {
namespace {

using test::built;
using test::mesh_family;
using test::QuadMesh;

QuadMesh lists_of(const Quadrangulation& mesh) {
    QuadMesh lists;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        lists.vertices.push_back(mesh.origin + mesh.vertex(v));
    lists.quads = mesh.quads;
    return lists;
}

Quadrangulation refined(Quadrangulation mesh, int times) {
    for (int k = 0; k < times; ++k) mesh = *refine(mesh);
    return mesh;
}

/// Other numbers for vertices and quads, and other first corners.
QuadMesh shuffled(const QuadMesh& mesh, unsigned seed) {
    std::mt19937 engine(seed);
    std::vector<Index> number(mesh.vertices.size());
    std::iota(number.begin(), number.end(), 0U);
    std::shuffle(number.begin(), number.end(), engine);
    QuadMesh out;
    out.vertices.resize(number.size());
    for (std::size_t v = 0; v < number.size(); ++v) out.vertices[number[v]] = mesh.vertices[v];
    for (auto quad : mesh.quads) {
        for (Index& v : quad) v = number[v];
        std::rotate(quad.begin(), quad.begin() + static_cast<int>(engine() % 4), quad.end());
        out.quads.push_back(quad);
    }
    std::shuffle(out.quads.begin(), out.quads.end(), engine);
    return out;
}

/// The refined base, with the numbers that `refinement` tells, is the mesh.
void expect_refines_to(const Refinement& refinement, const QuadMesh& mesh) {
    QuadMesh base;
    for (const Index v : refinement.vertices) base.vertices.push_back(mesh.vertices[v]);
    base.quads = refinement.quads;
    const Quadrangulation fine = refined(built(base), refinement.levels);
    ASSERT_EQ(fine.quads.size(), mesh.quads.size());
    ASSERT_EQ(refinement.finest.size(), mesh.quads.size());
    std::vector<int> met(mesh.quads.size());
    for (Index q = 0; q < fine.quad_count(); ++q) {
        const auto [quad, turn] = refinement.finest[q];
        ++met[quad];
        for (Index i = 0; i < 4; ++i) {
            const Vec2 expected = mesh.vertices[mesh.quads[quad][(i + turn) % 4]];
            const Vec2 found = fine.origin + fine.corners(q)[i];
            // Two roundings a level of coordinates up to 2e6.
            EXPECT_NEAR(found.x, expected.x, 1e-15 * (1 + std::abs(expected.x)) * 8);
            EXPECT_NEAR(found.y, expected.y, 1e-15 * (1 + std::abs(expected.y)) * 8);
        }
    }
    EXPECT_EQ(std::count(met.begin(), met.end(), 1), static_cast<std::ptrdiff_t>(met.size()));
}

TEST(Coarsen, UndoesRefinementInItsOwnNumbering) {
    for (const Quadrangulation& base : mesh_family()) {
        const auto step = coarsen(*refine(base));
        ASSERT_TRUE(step);
        EXPECT_EQ(step->mesh.quads, base.quads);
        EXPECT_EQ(step->mesh.edges, base.edges);
        for (Index v = 0; v < base.vertex_count(); ++v) EXPECT_EQ(step->vertices[v], v);
        for (Index q = 0; q < base.quad_count(); ++q)
            for (Index i = 0; i < 4; ++i)
                EXPECT_EQ(step->children[q][i], (TurnedQuad{4 * q + i, 0}));
    }
}

TEST(Coarsen, FindsAllLevelsInAnyNumbering) {
    unsigned seed = 1;
    for (const Quadrangulation& base : mesh_family())
        for (int levels = 1; levels <= 3; ++levels) {
            const QuadMesh mesh = shuffled(lists_of(refined(base, levels)), seed++);
            const Refinement refinement = refinement_of(built(mesh), 30);
            EXPECT_GE(refinement.levels, levels);  // 4 x 4 squares are a refinement themselves
            expect_refines_to(refinement, mesh);
        }
}

TEST(Coarsen, StopsWhereItIsTold) {
    const QuadMesh mesh = test::grid_mesh(8, 8);
    EXPECT_EQ(refinement_of(built(mesh), 30).levels, 3);
    EXPECT_EQ(refinement_of(built(mesh), 30).quads.size(), 1U);
    const Refinement two = refinement_of(built(mesh), 2);
    EXPECT_EQ(two.levels, 2);
    EXPECT_EQ(two.quads.size(), 4U);
    expect_refines_to(two, mesh);
    const Refinement none = refinement_of(built(mesh), 0);
    EXPECT_EQ(none.levels, 0);
    EXPECT_EQ(none.quads, mesh.quads);
    expect_refines_to(none, mesh);
}

TEST(Coarsen, RefusesWhatIsNoRefinement) {
    EXPECT_FALSE(coarsen(built(test::grid_mesh(3, 2))));
    EXPECT_FALSE(coarsen(built(test::grid_mesh(4, 4, 1, 0.1))));
    EXPECT_FALSE(coarsen(built(test::star_mesh(4))));
    QuadMesh moved = lists_of(refined(built(test::star_mesh(5)), 1));
    moved.vertices.back().x += 1e-6;  // a centre
    EXPECT_FALSE(coarsen(built(moved)));
    moved.vertices.back().x -= 1e-6 - 1e-11;
    EXPECT_TRUE(coarsen(built(moved)));
    EXPECT_FALSE(coarsen(built(test::without_quad(test::grid_mesh(4, 4), 5))));
}

}  // namespace
}  // namespace relief::mesh
