#include "relief/mesh/locate.h"

#include <limits>

#include "mesh/meshes.h"

namespace relief::mesh {
namespace {

/// The same question, asked of every quad.
Index first_quad(const Quadrangulation& mesh, Vec2 p, double slack) {
    for (Index q = 0; q < mesh.quad_count(); ++q) {
        const QuadCorners v = mesh.corners(q);
        bool inside = true;
        for (int i = 0; i < 4; ++i)
            inside = inside && cross(v[(i + 1) % 4] - v[i], p - v[i]) >= -slack;
        if (inside) return q;
    }
    return kNoQuad;
}

TEST(Locator, AgreesWithASearchOfAllQuads) {
    for (const Quadrangulation& mesh : test::mesh_family()) {
        const Locator locator(mesh);
        test::Noise noise(3);
        Vec2 high{0, 0};
        for (Index v = 0; v < mesh.vertex_count(); ++v)
            high = {std::max(high.x, mesh.x[v]), std::max(high.y, mesh.y[v])};
        int found = 0;
        for (int k = 0; k < 500; ++k) {
            const Vec2 p{1.2 * high.x * noise(), 1.2 * high.y * noise()};
            const auto place = locator.locate(mesh.origin + p);
            // The origin of the mesh may cost the point its last bits.
            const Index expected = first_quad(mesh, p, 0);
            ASSERT_EQ(place.has_value(), expected != kNoQuad);
            if (!place) continue;
            ++found;
            EXPECT_EQ(place->quad, expected);
            EXPECT_NEAR(length(place->point - p), 0, 1e-9);
        }
        EXPECT_GT(found, 100);
    }
}

TEST(Locator, EdgesAndCornersBelongToTheSmallestQuad) {
    for (const Quadrangulation& mesh : test::mesh_family()) {
        const Locator locator(mesh);
        const VertexQuads at = vertex_quads(mesh);
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            const auto place = locator.locate(mesh.origin + mesh.vertex(v));
            ASSERT_TRUE(place.has_value());
            EXPECT_EQ(place->quad, at.of(v)[0]) << "vertex " << v;
        }
        const auto sides = edge_quads(mesh);
        for (Index e = 0; e < mesh.edge_count(); ++e) {
            const Vec2 a = mesh.vertex(mesh.edges[e][0]);
            for (const double t : {1.0 / 3, 0.5, 0.7}) {
                const auto place = locator.locate(mesh.origin + (a + t * mesh.edge_vector(e)));
                ASSERT_TRUE(place.has_value());
                EXPECT_TRUE(place->quad == sides[e][0] || place->quad == sides[e][1]);
            }
        }
    }
}

TEST(Locator, OutsideAndHoles) {
    const Quadrangulation mesh = test::built(test::without_quad(test::grid_mesh(3, 3), 4));
    const Locator locator(mesh);
    EXPECT_FALSE(locator.locate({1.5, 1.5}));
    EXPECT_FALSE(locator.locate({-1e-6, 1}));
    EXPECT_FALSE(locator.locate({3.5, 3.5}));
    EXPECT_FALSE(locator.locate({std::numeric_limits<double>::quiet_NaN(), 1}));
    EXPECT_FALSE(locator.locate({std::numeric_limits<double>::infinity(), 1}));
    EXPECT_TRUE(locator.locate({3 + 1e-14, 1.5}));  // rounding is forgiven
    const Place hole = locator.nearest({1.5, 1.75});
    EXPECT_EQ(mesh.origin + hole.point, (Vec2{1.5, 2}));
    EXPECT_EQ(hole.quad, 6u);  // quad 7 of the full grid
    EXPECT_EQ(mesh.origin + locator.nearest({5, 4}).point, (Vec2{3, 3}));
    EXPECT_EQ(mesh.origin + locator.nearest({-2, 0.25}).point, (Vec2{0, 0.25}));
    EXPECT_EQ(mesh.origin + locator.nearest({0.5, 0.25}).point, (Vec2{0.5, 0.25}));
}

TEST(Locator, DescendsToTheChild) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const Quadrangulation fine = *refine(base);
        const Locator locator(base);
        test::Noise noise(9);
        for (Index q = 0; q < base.quad_count(); ++q) {
            const QuadCorners v = base.corners(q);
            for (int k = 0; k < 50; ++k) {
                const double s = 0.5 + 0.5 * noise();
                const double t = 0.5 + 0.5 * noise();
                const Vec2 low = v[0] + s * (v[1] - v[0]);
                const Vec2 p = low + t * (v[3] + s * (v[2] - v[3]) - low);
                const Index child = child_of(base, fine, {q, p});
                ASSERT_EQ(child / 4, q);
                const QuadCorners w = fine.corners(child);
                for (int i = 0; i < 4; ++i)
                    EXPECT_GE(cross(w[(i + 1) % 4] - w[i], p - w[i]), -1e-15);
            }
            const Vec2 centre = diagonals(v).centre;
            EXPECT_EQ(child_of(base, fine, {q, centre}), 4 * q);
        }
    }
}

}  // namespace
}  // namespace relief::mesh
