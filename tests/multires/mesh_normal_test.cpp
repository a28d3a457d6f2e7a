#include "multires/mesh_normal.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <set>

#include "multires/mesh_support.h"

namespace relief::multires {
namespace {

using mesh::Index;
using test::all_levels;
using test::distance;
using test::Level;
using test::noisy;
using test::Points;

void keep_inner(const Level& level, Points& c) {
    for (std::size_t v = 0; v < c.size(); ++v)
        if (level.rules.kinds[v] > VertexKind::Dart) c[v] = {};
}

/// P^T P through the fine mesh.
Points plain(const Level& level, const Points& x) {
    Points fine = level.subdivided(x);
    Points y(x.size());
    level.step().adjoint(fine.data(), fine.data() + x.size(), y.data());
    keep_inner(level, y);
    return y;
}

void expect_plain(const Level& level, unsigned seed, const std::string& name) {
    Points x = noisy(Points(level.coarse.vertex_count), seed, 1);
    keep_inner(level, x);
    const Points expected = plain(level, x);
    const MeshNormal normal(level.step());
    Points inner;
    for (std::size_t k = 0; k < normal.size(); ++k) inner.push_back(x[normal.vertices()[k]]);
    Points y(inner.size());
    MeshNormal::Passes passes(normal);
    normal.apply(inner.data(), y.data(), passes);
    for (std::size_t k = 0; k < y.size(); ++k)
        // Rows add up to at most twice the valence, over which roundings spread.
        ASSERT_LT(length(y[k] - expected[normal.vertices()[k]]), 1e-13) << name;
    const Points e = noisy(Points(x.size() + level.rules.new_count), seed + 1, 1);
    Points altered = e;
    Points sums(x.size());
    level.step().adjoint(altered.data(), altered.data() + x.size(), sums.data());
    const MeshNormal::Points adjoint = normal.adjoint(e.data(), e.data() + x.size(), passes);
    for (std::size_t k = 0; k < normal.size(); ++k)
        ASSERT_LT(length(adjoint[k] - sums[normal.vertices()[k]]), 1e-13) << name;
    std::set<Index> seen(normal.vertices().data(), normal.vertices().data() + normal.size());
    for (Index v = 0; v < x.size(); ++v)
        ASSERT_EQ(seen.count(v), level.rules.kinds[v] <= VertexKind::Dart ? 1U : 0U) << name;
}

TEST(MeshNormal, AsThroughTheFineMesh) {
    for (const auto& [name, level] : all_levels()) expect_plain(level, 3, name);
}

/// Creases that end inside, with both ends of an edge or of two, beside each other.
TEST(MeshNormal, Creases) {
    for (unsigned seed = 1; seed <= 40; ++seed)
        for (const mesh::Split split : {mesh::Split::Loop, mesh::Split::CatmullClark}) {
            const bool quads = split == mesh::Split::CatmullClark && seed % 2 == 0;
            const test::Shape shape =
                quads ? test::double_torus() : test::flipped(test::grid(5, 4, true), 25, seed);
            mesh::Topology mesh = shape.topology();
            MeshTags tags = test::some_tags(mesh, seed);
            std::mt19937 random(seed);
            for (auto& sharp : tags.sharp) sharp = sharp && random() % 3 != 0;
            expect_plain(Level(std::move(mesh), std::move(tags), split), seed, "creases");
        }
}

/// Meshes with regular parts, with and without creases and boundaries.
TEST(MeshNormal, RegularParts) {
    const mesh::Split split = mesh::Split::CatmullClark;
    for (const test::Shape& shape :
         {test::double_torus(), test::grid(3, 4, false), test::grid(5, 6, false, true),
          test::both(test::tetrahedron(), test::grid(4, 4, false))})
        for (unsigned seed = 1; seed <= 6; ++seed) {
            mesh::Topology mesh = shape.topology();
            MeshTags tags = seed % 2 == 0 ? MeshTags() : test::some_tags(mesh, seed);
            for (int step = 0; step < 2; ++step) {
                mesh::Topology fine = *mesh::refine(mesh, split);
                tags = refined(tags, mesh, fine, split);
                mesh = std::move(fine);
            }
            expect_plain(Level(std::move(mesh), std::move(tags), split), seed, "regular parts");
        }
}

/// Surfaces of all kinds, refined or not, with random creases and corners, in any order.
TEST(MeshNormal, Families) {
    const std::vector<test::Shape> shapes = {
        test::tetrahedron(),
        test::icosahedron(),
        test::triangulated(test::double_torus()),
        test::grid(4, 3, true),
        test::without_faces(test::grid(5, 5, true, true), {7, 8, 30}),
        test::both(test::octahedron(), test::grid(3, 3, true)),
        test::both(test::tetrahedron(), test::grid(3, 2, true))};
    EXPECT_TRUE(rc::check([&] {
        const auto seed = *rc::gen::inRange(1U, 10000U);
        const auto& shape = *rc::gen::elementOf(shapes);
        const auto split = *rc::gen::element(mesh::Split::Loop, mesh::Split::CatmullClark,
                                             mesh::Split::Sqrt3Odd, mesh::Split::Sqrt3Even);
        const bool sqrt3 = split == mesh::Split::Sqrt3Odd || split == mesh::Split::Sqrt3Even;
        mesh::Topology mesh =
            test::shuffled(test::flipped(shape, *rc::gen::inRange(0, 20), seed), seed).topology();
        MeshTags tags =
            !sqrt3 && *rc::gen::arbitrary<bool>() ? test::some_tags(mesh, seed) : MeshTags();
        if (split == mesh::Split::Sqrt3Even || (!sqrt3 && *rc::gen::arbitrary<bool>())) {
            const mesh::Split before = sqrt3 ? mesh::Split::Sqrt3Odd : split;
            mesh::Topology fine = *mesh::refine(mesh, before);
            tags = refined(tags, mesh, fine, before);
            mesh = std::move(fine);
        }
        expect_plain(Level(std::move(mesh), std::move(tags), split), seed, "families");
    }));
}

}  // namespace
}  // namespace relief::multires
