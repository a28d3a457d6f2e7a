#include "relief/mesh/near_order.h"

#include <gtest/gtest.h>

#include "shapes.h"
#include "support.h"

namespace relief::mesh {
namespace {

/// The same mesh: corners, twins, and what `build` numbers.
void expect_same(const Topology& mesh) {
    Renumbered near = near_order(mesh);
    number_edges(near.mesh);
    ASSERT_EQ(near.mesh.edge_count, mesh.edge_count);
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        const Index old = near.half_edge(h);
        ASSERT_EQ(near.vertices[near.mesh.origin[h]], mesh.origin[old]);
        const Index twin = near.mesh.twin[h];
        ASSERT_EQ(twin == kNone ? kNone : near.half_edge(twin), mesh.twin[old]);
    }
    const Topology built = *build(faces_of(near.mesh), mesh.vertex_count);
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        ASSERT_EQ(near.mesh.twin[h], built.twin[h]);
        ASSERT_EQ(near.mesh.edge[h], built.edge[h]);
    }
}

TEST(NearOrder, ShuffledMeshes) {
    const test::Shape shapes[] = {test::icosahedron(), test::grid(9, 7, true, true),
                                  test::grid(8, 8, false), test::double_torus(),
                                  test::both(test::cube(), test::grid(3, 4, false))};
    unsigned seed = 0;
    for (const test::Shape& shape : shapes) {
        expect_same(shape.topology());
        expect_same(test::shuffled(shape, ++seed).topology());
    }
}

TEST(NearOrder, NeighboursAreNear) {
    const Topology mesh = test::shuffled(test::grid(60, 60, false), 3).topology();
    const Renumbered near = near_order(mesh);
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        if (near.mesh.on_boundary(h)) continue;
        // A search front on a grid of n x n has at most 4 n faces; two of them follow each other.
        const Index f = near.mesh.face_of(h);
        const Index g = near.mesh.face_of(near.mesh.twin[h]);
        EXPECT_LE(f > g ? f - g : g - f, 2 * 4 * 60U);
    }
}

TEST(NearOrder, KeepsTheFirstFacesOfComponents) {
    const Topology mesh = test::shuffled(test::both(test::cube(), test::cube()), 9).topology();
    const Renumbered near = near_order(mesh);
    const Components before = components(mesh);
    const Components after = components(near.mesh);
    ASSERT_EQ(after.count, 2U);
    EXPECT_EQ(near.faces[0], 0U);
    for (Index f = 0; f < mesh.face_count; ++f)
        EXPECT_EQ(after.of_face[f], before.of_face[near.faces[f]]);
}

}  // namespace
}  // namespace relief::mesh
