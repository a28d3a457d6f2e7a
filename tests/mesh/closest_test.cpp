#include "relief/mesh/closest.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "relief/core/parallel.h"
#include "shapes.h"
#include "support.h"

namespace relief::mesh {
namespace {

using Point = Vec3<double>;
using Corners = std::array<Point, 3>;

PolygonMesh mesh_of(const test::Shape& shape) {
    return {.vertices = shape.points,
            .offsets = shape.faces.offsets,
            .corners = {shape.faces.corners.begin(), shape.faces.corners.end()}};
}

/// A square of n x n cells in the plane z.
PolygonMesh square(int n, double z, double size = 1) {
    PolygonMesh mesh;
    for (int k = 0; k <= n; ++k)
        for (int i = 0; i <= n; ++i) mesh.vertices.push_back({size * i / n, size * k / n, z});
    for (int k = 0; k < n; ++k)
        for (int i = 0; i < n; ++i) {
            const std::int32_t v = k * (n + 1) + i;
            mesh.add_polygon(std::array{v, v + 1, v + n + 2, v + n + 1});
        }
    return mesh;
}

/// Latitudes and longitudes of a sphere about the origin.
PolygonMesh sphere(int n, double radius) {
    PolygonMesh mesh;
    for (int k = 0; k <= n; ++k)
        for (int i = 0; i < 2 * n; ++i) {
            const double u = M_PI * i / n;
            const double v = M_PI * k / n;
            mesh.vertices.push_back({radius * std::sin(v) * std::cos(u),
                                     radius * std::sin(v) * std::sin(u), radius * std::cos(v)});
        }
    for (std::int32_t k = 0; k < n; ++k)
        for (std::int32_t i = 0; i < 2 * n; ++i) {
            const std::int32_t next = (i + 1) % (2 * n);
            mesh.add_polygon(std::array{2 * n * k + i, 2 * n * (k + 1) + i, 2 * n * (k + 1) + next,
                                        2 * n * k + next});
        }
    return mesh;
}

Point random_point(test::Noise& noise) {
    const double x = noise();
    const double y = noise();
    return {x, y, noise()};
}

TEST(Closest, PointsOfATriangle) {
    const Corners t = {Point{0, 0, 0}, Point{4, 0, 0}, Point{0, 2, 0}};
    const auto expect = [&](const Point& p, const Point& closest) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Point q = closest_point({t[k], t[(k + 1) % 3], t[(k + 2) % 3]}, p);
            EXPECT_LE(length(q - closest), 1e-15) << p.x << " " << p.y;
        }
    };
    expect({1, 0.5, 3}, {1, 0.5, 0});  // above the inside
    expect({1, -2, 1}, {1, 0, 0});     // sides
    expect({-1, 1, -1}, {0, 1, 0});
    expect({3, 3, 0}, {2, 1, 0});
    expect({-1, -1, 5}, {0, 0, 0});  // corners
    expect({9, -1, 0}, {4, 0, 0});
    expect({-1, 4, 2}, {0, 2, 0});
}

TEST(Closest, TrianglesThatAreALineOrAPoint) {
    const Point a{1, 2, 3};
    EXPECT_EQ(closest_point({a, a, a}, {5, 5, 5}), a);
    const Corners line = {Point{0, 0, 0}, Point{1, 0, 0}, Point{3, 0, 0}};
    for (std::size_t k = 0; k < 3; ++k) {
        const Corners turned = {line[k], line[(k + 1) % 3], line[(k + 2) % 3]};
        EXPECT_EQ(closest_point(turned, {2, 1, 0}), (Point{2, 0, 0}));
        EXPECT_EQ(closest_point(turned, {7, 1, 1}), (Point{3, 0, 0}));
        EXPECT_EQ(closest_point(turned, {-1, 1, 1}), (Point{0, 0, 0}));
    }
}

/// A point over a known place of a triangle of any thinness, moved along the normal, finds that
/// place again.
TEST(Closest, ThinTriangles) {
    test::Noise noise(3);
    for (int k = 0; k < 2000; ++k) {
        const double thin = std::exp2(-(k % 60));
        Point along = random_point(noise);
        along = 1 / length(along) * along;
        Point across = cross(along, random_point(noise));
        across = thin / length(across) * across;
        const Point a = random_point(noise);
        const Corners t = {a, a + along, a + (0.5 + 0.4 * noise()) * along + across};
        const double u = 0.5 + 0.5 * noise();
        const double v = (1 - u) * (0.5 + 0.5 * noise());
        const Point place = a + u * (t[1] - a) + v * (t[2] - a);
        const Point normal = 1 / thin * cross(along, across);
        const double off = noise();
        // Roundings of coordinates up to 2, some of each.
        EXPECT_NEAR(length(closest_point(t, place + off * normal) - (place + off * normal)),
                    std::abs(off), 4e-15)
            << thin;
    }
}

/// Triangles of which some are lines or points, many equal.
std::vector<FanTriangle> soup(Index count, unsigned seed) {
    test::Noise noise(seed);
    std::vector<FanTriangle> triangles;
    for (Index k = 0; k < count; ++k) {
        Corners t = {random_point(noise), random_point(noise), random_point(noise)};
        t[1] = t[0] + 0.3 * t[1];
        t[2] = t[0] + 0.3 * t[2];
        if (k % 5 == 1) t[1] = t[0];
        if (k % 10 == 3) t[2] = t[1] = t[0];
        if (k % 7 == 2 && k > 2) t = triangles[k - 2].corners;
        triangles.push_back({t, k});
    }
    return triangles;
}

RC_GTEST_PROP(ClosestProperty, LikeAskingEveryTriangle, ()) {
    const auto triangles = soup(*rc::gen::inRange<Index>(1, 200), *rc::gen::arbitrary<unsigned>());
    const TriangleTree tree(triangles);
    test::Noise noise(*rc::gen::arbitrary<unsigned>());
    for (int k = 0; k < 20; ++k) {
        const Point p = 3 * random_point(noise);
        double least = HUGE_VAL;
        for (const FanTriangle& t : triangles)
            least = std::min(least, length(p - closest_point(t.corners, p)));
        const SurfacePoint found = tree.closest(p);
        RC_ASSERT(found.distance == least);
        RC_ASSERT(length(p - found.point) == least);
        RC_ASSERT(length(p - closest_point(triangles[found.face].corners, p)) == least);
        const double enough = 2 * std::abs(noise());
        const SurfacePoint near = tree.closest(p, enough);
        RC_ASSERT(near.distance == least || (near.distance > least && near.distance <= enough));
        RC_ASSERT(length(p - near.point) == near.distance);
        const SurfacePoint from = tree.closest_from(found.triangle, p);
        RC_ASSERT(from.distance == least && from.triangle == found.triangle);
        const auto any = static_cast<Index>(static_cast<std::size_t>(k) % triangles.size());
        const SurfacePoint far = tree.closest_from(any, p);
        RC_ASSERT(far.distance == least);
        RC_ASSERT(length(p - closest_point(triangles[far.face].corners, p)) == least);
    }
}

TEST(SurfaceDistance, ParallelSquares) {
    const SurfaceDistance d = *surface_distance(square(3, 0), square(5, 0.25), 1000);
    for (const DirectedDistance& way : {d.a_to_b, d.b_to_a}) {
        EXPECT_EQ(way.largest, 0.25);
        EXPECT_NEAR(way.rms, 0.25, 1e-15);  // a sum of 1000 equal squares, rounded
    }
    const SurfaceDistance same = *surface_distance(square(3, 1), square(3, 1), 1000);
    EXPECT_LE(same.largest(), 2e-16);  // samples are rounded
    EXPECT_LE(same.rms(), 2e-16);
}

/// A square on a larger one: nothing there, a known integral back.
TEST(SurfaceDistance, DirectionsDiffer) {
    const SurfaceDistance d = *surface_distance(square(4, 0), square(4, 0, 2));
    EXPECT_LE(d.a_to_b.largest, 2e-16);
    EXPECT_NEAR(d.b_to_a.largest, std::sqrt(2.0), 1e-15);
    EXPECT_EQ(d.b_to_a.farthest, (Point{2, 2, 0}));
    // The mean of x^2 over [0, 1] in two strips and of x^2 + y^2 in a square of four: 4 / 12.
    EXPECT_NEAR(d.b_to_a.rms, std::sqrt(1 / 3.0),
                1e-4);  // 60 000 even samples of a smooth function
    EXPECT_EQ(d.rms(), d.b_to_a.rms);
    EXPECT_EQ(d.largest(), d.b_to_a.largest);
}

TEST(SurfaceDistance, SphereAgainstScaledSphere) {
    const SurfaceDistance d = *surface_distance(sphere(60, 1), sphere(60, 1.5), 20000);
    // Facets sag by 1 - cos(pi / 120), 3.5e-4 of the radius, at the middle of both directions.
    EXPECT_NEAR(d.a_to_b.largest, 0.5, 1e-3);
    EXPECT_NEAR(d.b_to_a.largest, 0.5, 1e-3);
    EXPECT_NEAR(d.a_to_b.rms, 0.5, 1e-3);
    EXPECT_NEAR(d.b_to_a.rms, 0.5, 1e-3);
}

/// No sample falls on a vertex that is moved alone: the vertices themselves tell.
TEST(SurfaceDistance, AMovedVertexTells) {
    const PolygonMesh flat = square(20, 0);
    PolygonMesh spiked = flat;
    spiked.vertices[21 * 10 + 10][2] = 0.125;
    const SurfaceDistance d = *surface_distance(spiked, flat, 500);
    EXPECT_EQ(d.a_to_b.largest, 0.125);
    EXPECT_EQ(d.a_to_b.farthest, (Point{0.5, 0.5, 0.125}));
    EXPECT_LT(d.b_to_a.largest, 0.125);
    // A vertex without faces is no part of the surface.
    PolygonMesh more = flat;
    more.vertices.push_back({9, 9, 9});
    EXPECT_LE(surface_distance(more, flat, 500)->largest(), 2e-16);
    const std::vector<double> distances =
        vertex_distances(spiked, TriangleTree(fan_triangles(flat)));
    ASSERT_EQ(distances.size(), spiked.vertices.size());
    for (std::size_t v = 0; v < distances.size(); ++v)
        EXPECT_EQ(distances[v], spiked.vertices[v][2]);
}

/// Samples are even: each half of a square with cells of very different sizes gets its part.
TEST(SurfaceDistance, SamplesFollowTheArea) {
    PolygonMesh strips;
    for (const double x : {0.0, 0.001, 0.002, 0.003, 0.5, 1.0})
        for (const double y : {0.0, 1.0}) strips.vertices.push_back({x, y, 0});
    for (std::int32_t k = 0; k < 10; k += 2) strips.add_polygon(std::array{k, k + 2, k + 3, k + 1});
    PolygonMesh side;  // the distance to this is x
    side.vertices = {{0, -1, -1}, {0, 2, -1}, {0, 2, 1}, {0, -1, 1}};
    side.add_polygon(std::array{0, 1, 2, 3});
    const SurfaceDistance d = *surface_distance(strips, side, 10000);
    EXPECT_NEAR(d.a_to_b.rms, std::sqrt(1 / 3.0), 1e-4);  // 1e4 samples of a smooth function
    EXPECT_EQ(d.a_to_b.largest, 1);
}

TEST(SurfaceDistance, SurfacesWithoutArea) {
    PolygonMesh needle;
    needle.vertices = {{0.25, 0.25, 1}, {0.25, 0.25, 3}};
    needle.add_polygon(std::array{0, 1, 0});
    const SurfaceDistance d = *surface_distance(needle, square(1, 0), 1000);
    EXPECT_EQ(d.a_to_b.largest, 3);
    EXPECT_EQ(d.b_to_a.largest, std::sqrt(0.75 * 0.75 * 2 + 1));
    EXPECT_FALSE(surface_distance(needle, {}).ok());
    const auto refused = surface_distance({}, needle);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().text(), "the first mesh: empty_mesh: it has no polygon to measure");
}

TEST(SurfaceDistance, SameForAnyThreadCount) {
    const PolygonMesh a = mesh_of(test::grid(40, 30, true, true));
    const PolygonMesh b = mesh_of(test::grid(35, 25, false, true));
    const auto numbers = [&] {
        const SurfaceDistance d = *surface_distance(a, b, 5000);
        return std::array{d.a_to_b.largest, d.a_to_b.rms,        d.b_to_a.largest,
                          d.b_to_a.rms,     d.a_to_b.farthest.x, d.b_to_a.farthest.x};
    };
    set_thread_count(1);
    const auto one = numbers();
    set_thread_count(4);
    const auto four = numbers();
    set_thread_count(0);
    EXPECT_EQ(one, four);
}

}  // namespace
}  // namespace relief::mesh
