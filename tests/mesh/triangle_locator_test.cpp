#include "relief/mesh/triangle_locator.h"

#include <algorithm>
#include <limits>

#include "mesh/triangle_meshes.h"
#include "relief/core/parallel.h"
#include "relief/mesh/delaunay.h"

namespace relief::mesh {
namespace {

/// The same question, asked of every triangle.
Index first_triangle(const Triangulation& mesh, Vec2 p, double least) {
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        const double area = orient(a, b, c);
        if (orient(a, b, p) >= least * area && orient(b, c, p) >= least * area &&
            orient(c, a, p) >= least * area)
            return t;
    }
    return kNone;
}

Triangulation triangulated(const std::vector<Vec2>& points) {
    auto result = delaunay(points);
    if (!result.ok()) throw std::runtime_error(result.error().text());
    return std::move(result->mesh);
}

/// Two dense clusters at the ends of a line: cells that the grid can not separate.
Triangulation clusters() {
    test::Noise noise(5);
    std::vector<Vec2> points;
    for (int k = 0; k < 1500; ++k) {
        const double end = k % 2 ? 1 : -1;
        points.push_back({end + 1e-4 * noise(), 1e-4 * noise()});
    }
    return triangulated(points);
}

/// Slivers whose boxes overlap each other almost everywhere.
Triangulation fan() {
    constexpr Index kSlivers = 700;
    test::TriangleMesh mesh{{{5, 2}}, {}};
    for (Index k = 0; k < kSlivers; ++k) {
        const double angle = 2 * 3.14159265358979323846 * k / kSlivers;
        mesh.vertices.push_back({5 + std::cos(angle), 2 + std::sin(angle)});
        mesh.triangles.push_back({0, 1 + k, 1 + (k + 1) % kSlivers});
    }
    return test::built(mesh);
}

std::vector<Triangulation> family() {
    auto meshes = test::triangulation_family();
    meshes.push_back(clusters());
    meshes.push_back(fan());
    test::Noise noise(9);
    std::vector<Vec2> points;
    for (int k = 0; k < 2000; ++k) points.push_back({4e5 + 100 * noise(), 100 * noise()});
    meshes.push_back(triangulated(points));
    return meshes;
}

/// Points of the mesh's box and beyond, of its vertices and its edges, in the source's coordinates.
std::vector<Vec2> queries(const Triangulation& mesh) {
    test::Noise noise(3);
    Vec2 high{0, 0};
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        high = {std::max(high.x, mesh.x[v]), std::max(high.y, mesh.y[v])};
    std::vector<Vec2> points;
    for (int k = 0; k < 300; ++k)
        points.push_back(mesh.origin + Vec2{1.1 * high.x * noise(), 1.1 * high.y * noise()});
    for (Index v = 0; v < std::min(mesh.vertex_count(), 300U); ++v)
        points.push_back(mesh.origin + mesh.vertex(v));
    for (Index e = 0; e < std::min(mesh.edge_count(), 300U); ++e)
        points.push_back(mesh.origin + (mesh.vertex(mesh.edges[e][0]) + 0.3 * mesh.edge_vector(e)));
    for (Index t = 0; t < std::min(mesh.triangle_count(), 300U); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        points.push_back(mesh.origin + (a + 0.3 * (b - a) + 0.2 * (c - a)));
    }
    return points;
}

TEST(TriangleLocator, AgreesWithASearchOfAllTriangles) {
    for (const Triangulation& mesh : family()) {
        const TriangleLocator locator(mesh);
        Index inside = 0;
        for (const Vec2 point : queries(mesh)) {
            const Vec2 p = point - mesh.origin;
            const Index found = locator.locate(point);
            // The edges of a triangle are looked at in another order there: on them roundings
            // differ.
            const Index strict = first_triangle(mesh, p, 1e-10);
            const Index loose = first_triangle(mesh, p, -1e-10);
            if (strict == loose) {
                EXPECT_EQ(found, strict);
            } else if (found != kNone) {
                EXPECT_GE(found, loose);
                const auto [a, b, c] = mesh.corners(found);
                const double area = orient(a, b, c);
                for (const double side : {orient(a, b, p), orient(b, c, p), orient(c, a, p)})
                    EXPECT_GE(side, -1e-10 * area);
            }
            inside += found != kNone;
        }
        EXPECT_GT(inside, 3U);
    }
}

TEST(TriangleLocator, VerticesAndEdgesBelongToTheSmallestTriangle) {
    for (const Triangulation& mesh :
         {test::built(test::triangle_grid(4, 4)), test::built(test::triangle_grid(3, 3, 0.1))}) {
        const TriangleLocator locator(mesh);
        const VertexStars stars = vertex_triangles(mesh);
        for (Index v = 0; v < mesh.vertex_count(); ++v)
            EXPECT_EQ(locator.locate(mesh.origin + mesh.vertex(v)), stars.of(v)[0]);
        for (Index e = 0; e < mesh.edge_count(); ++e) {
            const Vec2 middle =
                midpoint(mesh.vertex(mesh.edges[e][0]), mesh.vertex(mesh.edges[e][1]));
            const auto [left, right] = mesh.edge_triangles[e];
            // The tolerance of 1e-12 forgives the rounding of the middle.
            EXPECT_EQ(locator.locate(mesh.origin + middle), std::min(left, right));
        }
    }
}

TEST(TriangleLocator, OutsideHolesAndWhatIsNoPoint) {
    const Triangulation mesh = test::built(test::without_triangle(test::triangle_grid(3, 3), 8));
    const TriangleLocator locator(mesh);
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(locator.locate({1.75, 1.25}), kNone);  // triangle 8: (1,1), (2,1), (2,2)
    EXPECT_NE(locator.locate({1.25, 1.75}), kNone);
    for (const Vec2 p : {Vec2{-1e-6, 1},
                         {3.5, 3.5},
                         {1e300, -1e300},
                         {infinity, 1},
                         {1, -infinity},
                         {std::nan(""), 1},
                         {1, std::nan("")}})
        EXPECT_EQ(locator.locate(p), kNone);
    EXPECT_NE(locator.locate({3 + 0.5e-12, 1.5}), kNone);  // at most 1e-12 of a height of 1
    EXPECT_EQ(locator.locate({3 + 2e-12, 1.5}), kNone);
}

TEST(TriangleLocator, ManyPointsGiveWhatEachGives) {
    for (const Triangulation& mesh : family()) {
        const TriangleLocator locator(mesh);
        std::vector<Vec2> points = queries(mesh);
        const std::size_t few = points.size();
        for (int k = 0; k < 5; ++k)
            points.insert(points.end(), points.begin(), points.begin() + few);
        std::vector<Index> expected;
        for (const Vec2 p : points) expected.push_back(locator.locate(p));
        for (const int threads : {1, 3}) {
            set_thread_count(threads);
            std::vector<Index> found(points.size());
            locator.locate(points, found);
            EXPECT_EQ(found, expected);
        }
        set_thread_count(0);
        std::vector<Index> found(2);
        locator.locate(std::span(points).first(2), found);
        EXPECT_EQ(found, (std::vector{expected[0], expected[1]}));
        locator.locate({}, {});
    }
}

TEST(TriangleLocator, NearestIsThePointItselfOrOnTheBoundary) {
    for (const Triangulation& mesh : family()) {
        const TriangleLocator locator(mesh);
        for (const Vec2 point : queries(mesh)) {
            const Vec2 p = point - mesh.origin;
            const Index inside = locator.locate(point);
            const TrianglePlace place = locator.nearest(point);
            if (inside != kNone) {
                EXPECT_EQ(place.triangle, inside);
                EXPECT_EQ(place.point, p);
                continue;
            }
            double nearest = std::numeric_limits<double>::infinity();
            for (Index e = 0; e < mesh.edge_count(); ++e) {
                if (!mesh.on_boundary(e)) continue;
                const Vec2 a = mesh.vertex(mesh.edges[e][0]);
                const Vec2 ab = mesh.edge_vector(e);
                const double t = std::clamp(dot(p - a, ab) / dot(ab, ab), 0.0, 1.0);
                nearest = std::min(nearest, length(p - (a + t * ab)));
            }
            // One rounding of a + ab at ends of edges.
            EXPECT_NEAR(length(place.point - p), nearest, 1e-15 * (1 + length(p)));
            const auto [a, b, c] = mesh.corners(place.triangle);
            const double area = orient(a, b, c);
            const double size = std::max({length(b - a), length(c - b), length(a - c)});
            // Of the point's coordinates, times the length of a side.
            const double rounding = 1e-15 * size * (size + length(place.point));
            for (const double side :
                 {orient(a, b, place.point), orient(b, c, place.point), orient(c, a, place.point)})
                EXPECT_GE(side, -1e-12 * area - rounding);
        }
    }
}

TEST(TriangleLocator, NearestTakesTheFirstOfEqualEdges) {
    const Triangulation mesh = test::built(test::triangle_grid(1, 1));
    const TriangleLocator locator(mesh);
    const TrianglePlace corner = locator.nearest({-3, -4});
    EXPECT_EQ(mesh.origin + corner.point, (Vec2{0, 0}));
    EXPECT_EQ(corner.triangle, 0u);  // of edge 0-1; edge 0-2 is of triangle 1
    const TrianglePlace side = locator.nearest({0.25, 9});
    EXPECT_EQ(mesh.origin + side.point, (Vec2{0.25, 1}));
    EXPECT_EQ(side.triangle, 1u);
}

}  // namespace
}  // namespace relief::mesh
