#include "relief/spline/control_triangle.h"

#include <rapidcheck.h>

#include <limits>
#include <numbers>

#include "support.h"

namespace relief::spline {
namespace {

double area(const TriangleCorners& t) {
    return 0.5 * orient(t[0], t[1], t[2]);
}

/// How far the points reach out of the triangle, in barycentric coordinates.
double excess(const TriangleCorners& t, const std::vector<Vec2>& points) {
    double most = 0;
    for (const Vec2 p : points)
        for (const double weight : barycentric(t, p)) most = std::max(most, -weight);
    return most;
}

std::vector<Vec2> regular(int corners) {
    std::vector<Vec2> points;
    for (int k = 0; k < corners; ++k) {
        const double angle = 2 * std::numbers::pi * k / corners;
        points.push_back({std::cos(angle), std::sin(angle)});
    }
    return points;
}

TEST(ControlTriangle, Golden) {
    const nlohmann::json file = test::reference("powell_sabin.json");
    for (const auto& item : file["min_triangle"]) {
        std::vector<Vec2> points;
        for (const auto& p : item["points"]) points.push_back({p[0], p[1]});
        const auto triangle = smallest_triangle(points);
        ASSERT_TRUE(triangle);
        const double expected = item["area"];
        EXPECT_NEAR(area(*triangle), expected, 1e-12 * expected);
        EXPECT_LE(excess(*triangle, points), 1e-12);
    }
}

TEST(ControlTriangle, KnownAreas) {
    // A triangle flush with three alternate sides of a hexagon, or half as large again as the
    // inscribed one; twice a parallelogram.
    EXPECT_NEAR(area(*smallest_triangle(regular(6))), 9 * std::sqrt(3) / 4, 1e-12);
    const std::vector<Vec2> square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}, {0.5, 0}};
    EXPECT_NEAR(area(*smallest_triangle(square)), 2, 1e-12);
    const std::vector<Vec2> triangle = {{5, 5}, {9, 5}, {5, 8}, {6, 6}, {7, 5}};
    EXPECT_NEAR(area(*smallest_triangle(triangle)), 6, 1e-12);
}

/// Abscissae that differ by rounding only, so that the leftmost point is not a corner.
TEST(ControlTriangle, RoundedSquare) {
    const double e = 2.3e-16;
    const std::vector<Vec2> points = {{-1 + e, -1}, {-1 - e, 0},     {-1 + 3 * e, 1}, {0, 1 - e},
                                      {1, 1},       {1 + 2 * e, -1}, {0, -1 - e},     {-1, 0}};
    const auto triangle = smallest_triangle(points);
    ASSERT_TRUE(triangle);
    EXPECT_NEAR(area(*triangle), 8, 1e-12);
    EXPECT_LE(excess(*triangle, points), 1e-12);
}

TEST(ControlTriangle, Degenerate) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(smallest_triangle({}));
    EXPECT_FALSE(smallest_triangle(std::vector<Vec2>{{1, 2}}));
    EXPECT_FALSE(smallest_triangle(std::vector<Vec2>{{1, 2}, {1, 2}, {1, 2}}));
    EXPECT_FALSE(smallest_triangle(std::vector<Vec2>{{0, 0}, {1, 2}, {2, 4}, {3, 6}}));
    EXPECT_FALSE(smallest_triangle(std::vector<Vec2>{{0, 0}, {nan, 2}, {2, 1}}));
}

TEST(ControlTriangle, EnclosesThinSets) {
    test::Noise noise(3);
    for (const double thickness : {1.0, 1e-2, 1e-4, 1e-6}) {
        std::vector<Vec2> points;
        for (int k = 0; k < 15; ++k) {
            const double along = noise();
            const double across = thickness * noise();
            points.push_back({0.8 * along - 0.6 * across, 0.6 * along + 0.8 * across});
        }
        const auto triangle = smallest_triangle(points);
        ASSERT_TRUE(triangle);
        // Roundings of coordinates count by the aspect.
        EXPECT_LE(excess(*triangle, points) * thickness, 1e-12);
    }
}

/// No line beside an enclosing triangle of one flush side is better: the area of the best of many
/// random enclosing triangles, their three directions drawn at random.
TEST(ControlTriangle, NoRandomTriangleIsSmaller) {
    rc::check("random directions", [] {
        const auto seed = *rc::gen::arbitrary<std::uint32_t>();
        test::Noise noise(seed);
        const int count = *rc::gen::inRange(3, 27);
        std::vector<Vec2> points;
        for (int k = 0; k < count; ++k) points.push_back({noise(), 0.3 * noise()});
        const auto triangle = smallest_triangle(points);
        RC_ASSERT(triangle.has_value());
        RC_ASSERT(excess(*triangle, points) < 1e-12);
        for (int trial = 0; trial < 300; ++trial) {
            std::array<Vec2, 3> normal;
            std::array<double, 3> support;
            for (int k = 0; k < 3; ++k) {
                normal[k] = unit({noise(), noise()});
                support[k] = -INFINITY;
                for (const Vec2 p : points) support[k] = std::max(support[k], dot(normal[k], p));
            }
            TriangleCorners corners;
            bool bounded = true;
            for (int k = 0; k < 3; ++k) {
                const Vec2 a = normal[k];
                const Vec2 b = normal[(k + 1) % 3];
                bounded = bounded && cross(a, b) > 1e-3;
                corners[k] =
                    (1 / cross(a, b)) * Vec2{support[k] * b.y - support[(k + 1) % 3] * a.y,
                                             support[(k + 1) % 3] * a.x - support[k] * b.x};
            }
            if (bounded) RC_ASSERT(area(corners) >= area(*triangle) * (1 - 1e-9));
        }
    });
}

}  // namespace
}  // namespace relief::spline
