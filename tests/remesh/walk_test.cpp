#include "meshes.h"
#include "relief/remesh/surface.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using test::Shape;

constexpr double kRounding = 1e-12;

double distance(const Vec3<double>& a, const Vec3<double>& b) {
    return length(a - b);
}

TEST(Walk, OnAFlatGridIsTheAdditionOfVectors) {
    Shape grid = test::grid(9, 7, true);
    for (auto& p : grid.points) p[2] = 0;
    const Surface surface = test::surface_of(grid);
    rc::check("walk(p, v) = p + v", [&] {
        const auto face = *rc::gen::inRange<Index>(0, surface.mesh.face_count);
        const double u = *rc::gen::inRange(0, 1001) / 1000.0;
        const double v = *rc::gen::inRange(0, 1001) / 1000.0;
        const Place from{face, {1 - u, u * (1 - v), u * v}};
        const Vec3<double> start = surface.point(from);
        const Vec3<double> end{*rc::gen::inRange(1, 789) / 1000.0,
                               *rc::gen::inRange(1, 613) / 1000.0, 0};
        const Place to = walk(surface, from, end - start);
        RC_ASSERT(distance(surface.point(to), end) < kRounding);
        for (const double w : to.weights) RC_ASSERT(w >= 0);
    });
}

TEST(Walk, AroundATubeReturnsToWhereItBegan) {
    const int sides = 24;
    const Surface surface = test::surface_of(test::tube(sides, 6, 3));
    const double around = sides * 2 * std::sin(M_PI / sides) / surface.diagonal;
    for (Index face = 0; face < surface.mesh.face_count; ++face) {
        const Place from{face, {0.3, 0.5, 0.2}};
        const Vec3<double>& n = surface.face_normals[face];
        const Vec3<double> ahead = cross(Vec3<double>{0, 0, 1}, n);
        const Place to = walk(surface, from, around * ahead);
        // 24 faces, each of which rounds.
        EXPECT_LT(distance(surface.point(to), surface.point(from)), 1e-11) << face;
    }
}

TEST(Walk, SlidesAlongTheBoundary) {
    Shape grid = test::grid(4, 4, true);
    for (auto& p : grid.points) p[2] = 0;
    const Surface surface = test::surface_of(grid);
    const double d = surface.diagonal;
    const Place from{0, {0.2, 0.4, 0.4}};
    const Vec3<double> start = surface.point(from);
    const Vec3<double> end = surface.point(walk(surface, from, {1 / d, -3 / d, 0}));
    EXPECT_NEAR(end.y, 0, kRounding);
    EXPECT_NEAR(end.x, start.x + 1 / d, kRounding);
    const Vec3<double> corner = surface.point(walk(surface, from, {9 / d, 9 / d, 0}));
    EXPECT_LT(distance(corner, {4 / d, 4 / d, 0}), kRounding);
}

TEST(Walk, StaysOnFacesWithoutArea) {
    Shape shape{{}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}};
    shape.add({0, 1, 2});
    shape.add({0, 2, 3});
    const Surface surface = test::surface_of(shape);
    EXPECT_EQ(walk(surface, {0, {0.25, 0.5, 0.25}}, {0.1, 0.1, 0}), (Place{0, {0.25, 0.5, 0.25}}));
    const Place inside = walk(surface, {1, {0.25, 0.25, 0.5}}, {0, -1, 0});
    EXPECT_NEAR(surface.point(inside).y, 0, kRounding);
}

TEST(SurfaceOf, ScalesAndLeavesOutUnusedVertices) {
    PolygonMesh mesh = test::polygons_of(test::grid(2, 2, false));
    for (auto& v : mesh.vertices) v = {1e5 + 3 * v[0], 2e5 + 4 * v[1], 0};
    mesh.vertices.insert(mesh.vertices.begin(), {9e9, 9e9, 9e9});
    for (auto& c : mesh.corners) ++c;
    const auto surface = surface_of(mesh, {});
    ASSERT_TRUE(surface.ok()) << surface.error().text();
    EXPECT_EQ(surface->mesh.face_count, 8U);
    EXPECT_DOUBLE_EQ(surface->diagonal, 10);
    for (Index v = 0; v < surface->mesh.vertex_count; ++v) {
        const auto& p = mesh.vertices[surface->vertex_sources[v]];
        const Vec3<double> back = surface->original(surface->points[v]);
        EXPECT_NEAR(back.x, p[0], 1e-9);
        EXPECT_NEAR(back.y, p[1], 1e-9);
    }
}

TEST(SurfaceOf, NamesWhatCanNotBeRemeshed) {
    const auto text = [](const PolygonMesh& mesh) {
        const auto surface = surface_of(mesh, {});
        return surface.ok() ? "" : surface.error().text();
    };
    PolygonMesh mesh = test::polygons_of(test::octahedron());
    EXPECT_EQ(text({}), "mesh: empty_mesh: there is no face");
    PolygonMesh turned = mesh;
    std::swap(turned.corners[0], turned.corners[1]);
    EXPECT_NE(text(turned).find("face 1: non_manifold_edge"), std::string::npos) << text(turned);
    EXPECT_NE(text(turned).find("--repair"), std::string::npos) << text(turned);
    PolygonMesh holed = mesh;
    holed.vertices[3][1] = NAN;
    EXPECT_NE(text(holed).find("vertex 3"), std::string::npos) << text(holed);
    PolygonMesh large = mesh;
    large.vertices[2][0] = 1e80;
    EXPECT_EQ(text(large).substr(0, 20), "vertex 2: too_large:");
    PolygonMesh flat = mesh;
    for (auto& v : flat.vertices) v[1] = v[2] = 0;
    EXPECT_EQ(text(flat).substr(0, 14), "mesh: no_area:");
}

TEST(SurfaceOf, FindsFeaturesAndCorners) {
    std::set<test::Cell> cells;
    for (int x = 0; x < 5; ++x)
        for (int y = 0; y < 5; ++y)
            for (int z = 0; z < 5; ++z) cells.insert({x, y, z});
    const Surface surface = test::surface_of(test::voxels(cells), {.feature_degrees = 40});
    std::array<int, 3> kinds{};
    for (const VertexKind kind : surface.kinds) ++kinds[static_cast<std::size_t>(kind)];
    EXPECT_EQ(kinds, (std::array{6 * 16, 12 * 4, 8}));
}

}  // namespace

}  // namespace relief::remesh
