#include <gtest/gtest.h>

#include <random>

#include "edit/mesh_region.h"
#include "shapes.h"

namespace relief::edit {
namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Split;
using mesh::Topology;

std::vector<Index> list(const Buffer<Index>& numbers) {
    return {numbers.data(), numbers.data() + numbers.size()};
}

multires::MeshTags some_tags(const Topology& mesh, std::mt19937& random) {
    multires::MeshTags tags;
    for (Index e = 0; e < mesh.edge_count; ++e) tags.sharp.push_back(random() % 7 == 0);
    for (Index v = 0; v < mesh.vertex_count; ++v) tags.corner.push_back(random() % 9 == 0);
    return tags;
}

void expect_region(const MeshRegion& region, const Topology& whole, const multires::MeshTags& tags,
                   Split split) {
    const Topology& part = region.mesh;
    // A manifold with the numbers that `build` would give.
    const auto built = mesh::build(mesh::faces_of(part), part.vertex_count);
    ASSERT_TRUE(built.ok()) << built.error().text();
    EXPECT_EQ(list(built->twin), list(part.twin));
    EXPECT_EQ(list(built->edge), list(part.edge));
    EXPECT_EQ(built->edge_count, part.edge_count);
    if (split == Split::Sqrt3Even) {
        EXPECT_TRUE(mesh::check_split(part, split).ok());
    }
    // Everything in the order that it had.
    EXPECT_TRUE(std::is_sorted(region.vertices.begin(), region.vertices.end()));
    EXPECT_TRUE(std::is_sorted(region.half_edges.begin(), region.half_edges.end()));
    std::vector<bool> at_cut(part.vertex_count, false);
    for (Index h = 0; h < part.half_edge_count(); ++h) {
        const Index there = region.half_edges[h];
        EXPECT_EQ(region.vertices[part.origin[h]], whole.origin[there]);
        EXPECT_EQ(region.tags.sharp[part.edge[h]], tags.sharp[whole.edge[there]]);
        const bool cut = part.on_boundary(h) && !whole.on_boundary(there);
        EXPECT_EQ(region.on_cut[part.edge[h]], cut);
        EXPECT_TRUE(!cut || region.has_cut);
        if (cut) at_cut[part.origin[h]] = at_cut[part.target(h)] = true;
    }
    for (Index v = 0; v < part.vertex_count; ++v)
        EXPECT_EQ(region.tags.corner[v] != 0, at_cut[v] || tags.corner[region.vertices[v]] != 0);
}

struct Case {
    test::Shape shape;
    Split split;
};

TEST(MeshRegion, IsAManifoldInTheSameOrder) {
    const test::Shape holed =
        test::without_faces(test::grid(14, 14, true, true), {60, 61, 150, 200, 260});
    const Case cases[] = {
        {holed, Split::Loop},
        {holed, Split::Sqrt3Odd},
        {test::flipped(test::grid(12, 12, true, true), 150, 4), Split::Sqrt3Even},
        {test::grid(12, 9, false), Split::CatmullClark},
        {test::both(test::double_torus(), test::tetrahedron()), Split::CatmullClark}};
    std::mt19937 random(3);
    for (const Case& c : cases) {
        const Topology whole = c.shape.topology();
        const VertexFaces around(whole);
        const multires::MeshTags tags = some_tags(whole, random);
        for (int trial = 0; trial < 30; ++trial) {
            std::vector<Index> seeds;
            for (int k = 0; k < 1 + trial % 4; ++k) seeds.push_back(random() % whole.vertex_count);
            const int rings = 1 + trial % 3;
            const MeshRegion region = region_around(whole, tags, around, seeds, rings, c.split);
            expect_region(region, whole, tags, c.split);
            for (const Index seed : seeds) {
                const auto place =
                    std::lower_bound(region.vertices.begin(), region.vertices.end(), seed);
                ASSERT_TRUE(place != region.vertices.end() && *place == seed);
                EXPECT_EQ(region.rings[static_cast<std::size_t>(place - region.vertices.begin())],
                          0);
            }
        }
        // As many rings as there are: the whole component, without a cut.
        const MeshRegion all =
            region_around(whole, tags, around, std::vector<Index>{0}, 1000, c.split);
        EXPECT_FALSE(all.has_cut);
        expect_region(all, whole, tags, c.split);
    }
}

TEST(VertexFaces, NeighboursAndEdges) {
    const Topology mesh = test::both(test::grid(3, 2, false), test::icosahedron()).topology();
    const VertexFaces around(mesh);
    std::vector<Index> neighbours;
    around.neighbours(mesh, 5, neighbours);  // inside the grid: 4 columns
    EXPECT_EQ(neighbours, (std::vector<Index>{1, 4, 6, 9}));
    neighbours.clear();
    around.neighbours(mesh, 0, neighbours);
    EXPECT_EQ(neighbours, (std::vector<Index>{1, 4}));
    std::set<std::array<Index, 2>> expected;
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        const Index a = mesh.origin[h];
        const Index b = mesh.target(h);
        expected.insert({std::min(a, b), std::max(a, b)});
    }
    const auto edges = edges_of(mesh, around);
    EXPECT_EQ(edges.size(), mesh.edge_count);
    EXPECT_EQ((std::set<std::array<Index, 2>>(edges.begin(), edges.end())), expected);
}

}  // namespace
}  // namespace relief::edit
