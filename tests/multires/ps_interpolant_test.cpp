#include "relief/multires/ps_interpolant.h"

#include <cmath>
#include <limits>

#include "ps_testing.h"

namespace relief::multires::ps {
namespace {

using namespace test;
using spline::PlaneJet;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Points of a square of 20 around (5, 5).
std::vector<Vec2> scattered(std::size_t count, std::uint64_t seed) {
    Noise noise(seed);
    std::vector<Vec2> points;
    for (std::size_t k = 0; k < count; ++k) points.push_back({5 + 10 * noise(), 5 + 10 * noise()});
    return points;
}

template <class Function>
std::vector<double> values_at(std::span<const Vec2> points, Function&& f) {
    std::vector<double> values;
    for (const Vec2 p : points) values.push_back(f(p));
    return values;
}

double wave(Vec2 p) {
    return std::sin(p.x) * std::cos(0.7 * p.y);
}

TEST(PsInterpolant, QuadraticsAreExact) {
    const std::vector<Vec2> points = scattered(500, 1);
    const auto quadratic = [](Vec2 p) {
        return 3 - p.x + 0.5 * p.y + 0.25 * p.x * p.x - 0.5 * p.x * p.y + 0.125 * p.y * p.y;
    };
    const Interpolant surface = must(Interpolant::create(points, values_at(points, quadratic)));
    const std::vector<Vec2> inner = {{5, 5}, {3.3, 8.1}, {9.7, 1.4}, {0.6, 5.2}};
    std::vector<PlaneJet> jets(inner.size());
    ASSERT_TRUE(surface.evaluate(inner, jets).ok());
    for (std::size_t k = 0; k < inner.size(); ++k) {
        const Vec2 p = inner[k];
        // Values reach 100; local fits of 15 points lose about three digits.
        EXPECT_NEAR(jets[k].value, quadratic(p), 1e-11);
        EXPECT_NEAR(jets[k].gradient.x, -1 + 0.5 * p.x - 0.5 * p.y, 1e-10);
        EXPECT_NEAR(jets[k].gradient.y, 0.5 - 0.5 * p.x + 0.25 * p.y, 1e-10);
        EXPECT_NEAR(jets[k].xx, 0.5, 1e-8);
        EXPECT_NEAR(jets[k].xy, -0.5, 1e-8);
        EXPECT_NEAR(jets[k].yy, 0.25, 1e-8);
    }
}

TEST(PsInterpolant, IsTheSplineOfItsParts) {
    const std::vector<Vec2> points = scattered(800, 2);
    const std::vector<double> values = values_at(points, wave);
    const Interpolant surface = must(Interpolant::create(points, values));

    const mesh::Delaunay delaunay = must(mesh::delaunay(points));
    std::vector<double> at_vertices(points.size());
    for (std::size_t k = 0; k < points.size(); ++k)
        at_vertices[delaunay.vertex_of_point[k]] = values[k];
    const auto gradients = must(estimate_gradients(delaunay.mesh, at_vertices));
    TangentPlanes planes;
    for (Index v = 0; v < at_vertices.size(); ++v) planes.push_back({at_vertices[v], gradients[v]});
    const Space space = must(make_space(delaunay.mesh));
    const Coefficients spline = coefficients(space, planes);
    const Surface whole = must(Surface::create(space, std::span(&spline, 1)));

    const std::vector<Vec2> queries = scattered(3000, 3);
    std::vector<PlaneJet> ours(queries.size());
    std::vector<PlaneJet> theirs(queries.size());
    ASSERT_TRUE(surface.evaluate(queries, ours, Outside::Nearest).ok());
    const mesh::TriangleLocator locator(space.mesh);
    ASSERT_TRUE(evaluate(whole, locator, queries, theirs, Outside::Nearest).ok());
    for (std::size_t k = 0; k < queries.size(); ++k) {
        // Coefficients round what tangent planes keep, more so in thin triangles.
        EXPECT_NEAR(ours[k].value, theirs[k].value, 1e-10) << k;
        EXPECT_NEAR(ours[k].gradient.x, theirs[k].gradient.x, 1e-7) << k;
    }
}

TEST(PsInterpolant, PassesThroughValuesAndTheirMeans) {
    std::vector<Vec2> points = scattered(200, 4);
    std::vector<double> values = values_at(points, wave);
    points.push_back(points[17]);
    values.push_back(values[17] + 4);
    values[17] -= 1;
    const Interpolant surface = must(Interpolant::create(points, values));
    EXPECT_EQ(surface.triangles().vertex_count(), 200u);
    std::vector<PlaneJet> jets(points.size());
    ASSERT_TRUE(surface.evaluate(points, jets, Outside::Nearest).ok());
    const double mean = 0.5 * (values[17] + values[200]);
    for (std::size_t k = 0; k < points.size(); ++k)
        // Sites move by 2^-51 of the extent, at slopes of at most 100.
        EXPECT_NEAR(jets[k].value, k == 17 || k == 200 ? mean : values[k], 1e-11) << k;
}

TEST(PsInterpolant, StaysUsableWhenMoved) {
    const std::vector<Vec2> points = scattered(100, 5);
    Interpolant first = must(Interpolant::create(points, values_at(points, wave)));
    Grid<double> before(8, 8);
    Grid<double> after(8, 8);
    const RasterFrame frame{{1, 1}, {1, 1}};
    ASSERT_TRUE(first.evaluate_raster(frame, before.view(), Outside::Nearest).ok());
    const Interpolant second = std::move(first);
    ASSERT_TRUE(second.evaluate_raster(frame, after.view(), Outside::Nearest).ok());
    for (std::int64_t r = 0; r < 8; ++r)
        for (std::int64_t c = 0; c < 8; ++c) {
            EXPECT_EQ(before(r, c), after(r, c));
            std::array<PlaneJet, 1> jet;
            const Vec2 place{1.0 + static_cast<double>(c), 1.0 + static_cast<double>(r)};
            ASSERT_TRUE(second.evaluate(std::span(&place, 1), jet, Outside::Nearest).ok());
            EXPECT_NEAR(jet[0].value, after(r, c), 1e-13);
        }
}

/// Many points are not visited in their order; the error still names the first.
TEST(PsInterpolant, TheFirstPointOutsideIsNamed) {
    const std::vector<Vec2> points = scattered(300, 6);
    const Interpolant surface = must(Interpolant::create(points, values_at(points, wave)));
    std::vector<Vec2> queries(2000, Vec2{5, 5});
    for (const std::size_t k : {1900, 411, 1200}) queries[k] = {-100.0 + static_cast<double>(k), 0};
    std::vector<PlaneJet> jets(queries.size());
    const Status outside = surface.evaluate(queries, jets);
    ASSERT_FALSE(outside.ok());
    EXPECT_EQ(outside.error().where, "point 411");
    queries[700] = {kNan, 0};
    const Status endless = surface.evaluate(queries, jets, Outside::Nearest);
    ASSERT_FALSE(endless.ok());
    EXPECT_EQ(endless.error().where, "point 700");
    EXPECT_TRUE(surface.evaluate(queries, jets, Outside::Nan).ok());
    EXPECT_TRUE(std::isnan(jets[411].value));
    EXPECT_EQ(jets[0].value, jets[1999].value);
}

TEST(PsInterpolant, NamesWhatIsWrong) {
    const std::vector<Vec2> points = scattered(10, 7);
    std::vector<double> values(10, 1.0);
    const auto error = [&] { return Interpolant::create(points, values).error(); };
    values[3] = kNan;
    EXPECT_EQ(error().where, "point 3");
    EXPECT_EQ(error().message.find("non_finite_data"), 0u);
    values.pop_back();
    EXPECT_EQ(error().message.find("size_mismatch"), 0u);
    const std::vector<Vec2> two(points.begin(), points.begin() + 2);
    const auto few = Interpolant::create(two, std::vector<double>(2));
    EXPECT_EQ(few.error().message.find("too_few_points"), 0u);
}

TEST(PsInterpolant, VertexMeansFollowWeights) {
    const std::vector<Index> vertex_of_point = {1, 0, 1, 2, 2};
    const std::vector<double> values = {4, 7, 8, 1, 3};
    EXPECT_EQ(vertex_means(3, vertex_of_point, values), (std::vector<double>{7, 6, 2}));
    const std::vector<double> weights = {3, 0, 1, 0, 0};
    EXPECT_EQ(vertex_means(3, vertex_of_point, values, weights), (std::vector<double>{7, 5, 2}));
}

}  // namespace
}  // namespace relief::multires::ps
