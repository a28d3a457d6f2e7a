#include "relief/multires/ps_adaptive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "franke.h"
#include "relief/mesh/triangle_locator.h"
#include "relief/multires/ps_surface.h"
#include "support.h"

namespace relief::multires::ps {
namespace {

struct Data {
    std::vector<Vec2> points;
    std::vector<double> values;

    [[nodiscard]] ScatteredData view() const { return {points, std::span(&values, 1), {}}; }
};

Data franke_data(int count, double noise_size, std::uint64_t seed = 1) {
    test::Noise noise(seed);
    Data data;
    for (int k = 0; k < count; ++k) {
        const Vec2 p{0.5 + 0.5 * noise(), 0.5 + 0.5 * noise()};
        data.points.push_back(p);
        data.values.push_back(test::franke(p.x, p.y).value + noise_size * noise());
    }
    return data;
}

/// Largest distance of the surface from the data, by evaluation alone.
double true_error(const AdaptiveSurface& surface, const Data& data) {
    const auto evaluator = Surface::create(surface.space, surface.components);
    const mesh::TriangleLocator locator(surface.space.mesh);
    std::vector<spline::PlaneJet> jets(data.points.size());
    EXPECT_TRUE(evaluate(*evaluator, locator, data.points, jets, Outside::Nearest).ok());
    double worst = 0;
    for (std::size_t k = 0; k < jets.size(); ++k)
        worst = std::max(worst, std::abs(jets[k].value - data.values[k]));
    return worst;
}

TEST(PsAdaptive, SmoothDataNeedFewVertices) {
    const Data data = franke_data(20000, 0);
    std::size_t before = 0;
    for (const double bound : {0.05, 0.01, 0.001}) {
        const auto surface = fit_within(data.view(), {bound});
        ASSERT_TRUE(surface.ok()) << surface.error().text();
        EXPECT_EQ(surface->beyond, 0U);
        EXPECT_LE(surface->report.max_error, bound);
        EXPECT_NEAR(true_error(*surface, data), surface->report.max_error, 1e-12);
        const std::size_t vertices = surface->space.mesh.vertex_count();
        EXPECT_GT(vertices, before);
        before = vertices;
    }
    EXPECT_LT(before, 2000U);  // of 20 000 points
}

TEST(PsAdaptive, NoiseBelowTheBoundIsLeftOutAndAboveItIsMet) {
    const Data data = franke_data(3000, 0.01);
    const auto loose = fit_within(data.view(), {0.05});
    EXPECT_EQ(loose->beyond, 0U);
    EXPECT_LT(loose->space.mesh.vertex_count(), 300U);
    const auto tight = fit_within(data.view(), {0.001});
    ASSERT_TRUE(tight.ok());
    EXPECT_EQ(tight->beyond, 0U) << tight->reason;
    EXPECT_LE(true_error(*tight, data), 0.001);
}

TEST(PsAdaptive, ZeroIsInterpolation) {
    const Data data = franke_data(300, 0.1);
    const auto surface = fit_within(data.view(), {0});
    ASSERT_TRUE(surface.ok());
    // Exactly, up to the rounding of heights that are raised.
    EXPECT_LT(surface->report.max_error, 1e-13);
    EXPECT_EQ(surface->space.mesh.vertex_count(), 300U);
}

TEST(PsAdaptive, WhatCanNotBeReachedIsTold) {
    Data data = franke_data(500, 0);
    data.points.push_back(data.points[17]);
    data.values.push_back(data.values[17] + 1);
    const auto split = fit_within(data.view(), {0.1});
    ASSERT_TRUE(split.ok());
    EXPECT_EQ(split->beyond, 2U);
    EXPECT_EQ(split->reason.substr(0, 17), "points 17 and 500");
    const Data noisy = franke_data(2000, 0.5);
    AdaptiveOptions few{0.01};
    few.most_vertices = 100;
    const auto stopped = fit_within(noisy.view(), few);
    ASSERT_TRUE(stopped.ok());
    EXPECT_GT(stopped->beyond, 0U);
    EXPECT_EQ(stopped->reason, "more vertices are needed than are allowed");
}

TEST(PsAdaptive, BadInputIsNamed) {
    Data data = franke_data(100, 0);
    EXPECT_EQ(fit_within(data.view(), {-1}).error().code, ErrorCode::InvalidArgument);
    data.values[5] = std::nan("");
    EXPECT_EQ(fit_within(data.view(), {1}).error().where, "point 5");
    Data line;
    for (int k = 0; k < 10; ++k) {
        line.points.push_back({0.5 * k, 1.0 * k});
        line.values.push_back(k);
    }
    EXPECT_EQ(fit_within(line.view(), {1}).error().message.substr(0, 16), "collinear_points");
}

TEST(PsAdaptive, VerticesAreSpreadOverTheHullAndTheMiddlesOfCells) {
    // A lattice of 9 x 9: its hull are four corners, 9 cells have their middles at 4 + 8/3 i, next
    // to which lie 1, 4 and 7. (4, 4) is there twice.
    std::vector<Vec2> points{{4, 4}};
    for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 9; ++x) points.push_back({double(x), double(y)});
    const auto places = [&](std::size_t count) {
        const auto mesh = spread_triangulation(points, count);
        EXPECT_TRUE(mesh.ok());
        std::vector<std::pair<double, double>> found;
        for (mesh::Index v = 0; v < mesh->vertex_count(); ++v)
            found.emplace_back(mesh->origin.x + mesh->x[v], mesh->origin.y + mesh->y[v]);
        std::sort(found.begin(), found.end());
        return found;
    };
    using Places = std::vector<std::pair<double, double>>;
    EXPECT_EQ(places(14), (Places{{0, 0},
                                  {0, 8},
                                  {1, 1},
                                  {1, 4},
                                  {1, 7},
                                  {4, 1},
                                  {4, 4},
                                  {4, 7},
                                  {7, 1},
                                  {7, 4},
                                  {7, 7},
                                  {8, 0},
                                  {8, 8}}));
    EXPECT_EQ(places(0), (Places{{0, 0}, {0, 8}, {8, 0}, {8, 8}}));
    EXPECT_FALSE(spread_triangulation({}, 5).ok());
}

TEST(PsAdaptive, NoPointLiesOutside) {
    // A bent side: triangles between it and its chords are slivers, which are peeled off.
    Data data = franke_data(2000, 0);
    for (int k = 0; k <= 200; ++k) {
        const double t = k / 200.0;
        data.points.push_back({t, -0.004 * t * (1 - t) * (k % 2 == 0 ? 1 : 0.9)});
        data.values.push_back(test::franke(t, 0).value);
    }
    const auto outside = [&](const mesh::Triangulation& mesh) {
        const mesh::TriangleLocator locator(mesh);
        return std::count_if(data.points.begin(), data.points.end(),
                             [&](Vec2 p) { return locator.locate(p) == mesh::kNone; });
    };
    const auto spread = spread_triangulation(data.points, 100);
    ASSERT_TRUE(spread.ok());
    EXPECT_EQ(outside(*spread), 0);
    for (const double bound : {0.1, 0.01}) {
        const auto surface = fit_within(data.view(), {bound});
        ASSERT_TRUE(surface.ok());
        EXPECT_EQ(outside(surface->space.mesh), 0);
    }
}

/// A hemisphere over its plane: vertices are where any of the three components needs them.
TEST(PsAdaptive, EveryComponentIsWithinTheBound) {
    test::Noise noise(9);
    std::vector<Vec2> points;
    std::vector<std::vector<double>> components(3);
    for (int k = 0; k < 4000; ++k) {
        const Vec2 p{noise(), noise()};
        points.push_back(p);
        components[0].push_back(std::sin(3 * p.x));
        components[1].push_back(p.y);
        components[2].push_back(std::cos(3 * p.x) * (1 + 0.2 * std::sin(5 * p.y)));
    }
    components[1].push_back(components[1][7] + 0.004);  // half the range is below the bound
    components[0].push_back(components[0][7]);
    components[2].push_back(components[2][7]);
    points.push_back(points[7]);
    const double bound = 0.003;
    const auto surface = fit_within({points, components, {}}, {bound});
    ASSERT_TRUE(surface.ok()) << surface.error().text();
    EXPECT_EQ(surface->beyond, 0U) << surface->reason;
    const auto evaluator = Surface::create(surface->space, surface->components);
    const mesh::TriangleLocator locator(surface->space.mesh);
    std::vector<spline::PlaneJet> jets(3 * points.size());
    ASSERT_TRUE(evaluate(*evaluator, locator, points, jets, Outside::Nearest).ok());
    double worst = 0;
    for (std::size_t k = 0; k < points.size(); ++k)
        for (std::size_t m = 0; m < 3; ++m)
            worst = std::max(worst, std::abs(jets[3 * k + m].value - components[m][k]));
    EXPECT_LE(worst, bound);
    EXPECT_NEAR(worst, surface->report.max_error, 1e-12);
    EXPECT_LT(surface->space.mesh.vertex_count(), 1000U);  // of 4000

    // The flat component alone needs the hull and little else.
    const auto flat = fit_within({points, std::span(components).subspan(1, 1), {}}, {bound});
    EXPECT_LT(4 * flat->space.mesh.vertex_count(), surface->space.mesh.vertex_count());
    components[1].back() += 1;
    const auto torn = fit_within({points, components, {}}, {bound});
    EXPECT_EQ(torn->reason.substr(0, 17), "points 7 and 4000");
    EXPECT_EQ(fit_within({points, {}, {}}, {bound}).error().message.substr(0, 15),
              "component_count");
}

}  // namespace
}  // namespace relief::multires::ps
