#include "relief/multires/ps_gradients.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "franke.h"
#include "relief/core/parallel.h"
#include "relief/core/simd.h"
#include "support.h"

namespace relief::multires::ps {
namespace {

using mesh::Index;
using mesh::Triangulation;
using Triangle = std::array<Index, 3>;

/// A lattice of side x side vertices of the unit square, moved by up to `shake` cells inside.
Triangulation shaken_square(Index side, double shake, unsigned seed = 1) {
    std::mt19937 random(seed);
    const double cell = 1.0 / (side - 1);
    const auto move = [&] { return shake * cell * (random() / 4294967295.0 - 0.5); };
    std::vector<Vec2> vertices;
    for (Index r = 0; r < side; ++r)
        for (Index c = 0; c < side; ++c) {
            const bool x_inside = c > 0 && c + 1 < side;
            const bool y_inside = r > 0 && r + 1 < side;
            const double dx = move();
            const double dy = move();
            vertices.push_back({c * cell + (x_inside ? dx : 0), r * cell + (y_inside ? dy : 0)});
        }
    std::vector<Triangle> triangles;
    for (Index r = 0; r + 1 < side; ++r)
        for (Index c = 0; c + 1 < side; ++c) {
            const Index v = r * side + c;
            triangles.push_back({v, v + 1, v + side + 1});
            triangles.push_back({v, v + side + 1, v + side});
        }
    return *mesh::build(vertices, triangles);
}

template <class F>
std::vector<double> values_of(const Triangulation& mesh, F&& f) {
    std::vector<double> values;
    for (Index v = 0; v < mesh.vertex_count(); ++v) values.push_back(f(mesh.vertex(v)));
    return values;
}

/// The largest distance from the true gradients.
template <class F>
double worst(const Triangulation& mesh, const std::vector<Vec2>& gradients, F&& gradient_of) {
    double off = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        off = std::max(off, length(gradients[v] - gradient_of(mesh.vertex(v))));
    return off;
}

TEST(PsGradients, QuadraticRuleMatchesTheReference) {
    const auto json = test::reference("powell_sabin_gradients.json");
    for (const auto& c : json["cases"]) {
        std::vector<Vec2> vertices;
        for (const auto& v : c["vertices"]) vertices.push_back({v[0], v[1]});
        std::vector<Triangle> triangles;
        for (const auto& t : c["triangles"]) triangles.push_back({t[0], t[1], t[2]});
        const auto mesh = mesh::build(vertices, triangles);
        ASSERT_TRUE(mesh.ok());
        const auto values = c["values"].get<std::vector<double>>();
        const auto found = *estimate_gradients(*mesh, values, {GradientRule::Quadratic, 0, 0});
        for (std::size_t v = 0; v < found.size(); ++v) {
            // Two decompositions of the same well-conditioned rows: section 14 asks for 1e-9.
            EXPECT_NEAR(found[v].x, c["gradients"][v][0].get<double>(), 1e-9) << c["name"] << v;
            EXPECT_NEAR(found[v].y, c["gradients"][v][1].get<double>(), 1e-9) << c["name"] << v;
        }
    }
}

TEST(PsGradients, PolynomialsUpToDegreeThree) {
    const Triangulation mesh = shaken_square(20, 0.4);
    const auto linear = [](Vec2 p) { return 2 + 3 * p.x - p.y; };
    const auto cubic = [](Vec2 p) {
        return p.x * p.x * p.x - 2 * p.x * p.y * p.y + p.x * p.y + 0.5 * p.y;
    };
    const auto flat = *estimate_gradients(mesh, values_of(mesh, linear));
    EXPECT_LT(worst(mesh, flat, [](Vec2) { return Vec2{3, -1}; }), 1e-9);
    const auto curved = *estimate_gradients(mesh, values_of(mesh, cubic));
    EXPECT_LT(
        worst(mesh, curved,
              [](Vec2 p) {
                  return Vec2{3 * p.x * p.x - 2 * p.y * p.y + p.y, -4 * p.x * p.y + p.x + 0.5};
              }),
        1e-9);
}

TEST(PsGradients, LargeOffsetsAndStripsKeepThem) {
    // 100 : 1, far from the origin: what counts is the distance of neighbours.
    const Triangulation unit = shaken_square(15, 0.4);
    std::vector<Vec2> vertices;
    for (Index v = 0; v < unit.vertex_count(); ++v)
        vertices.push_back({2e6 + 100 * unit.x[v], -1e6 + unit.y[v]});
    const Triangulation mesh = *mesh::build(vertices, unit.triangles);
    const auto quadratic = [](Vec2 p) { return 1e-4 * p.x * p.x + p.x * p.y - p.y * p.y; };
    const auto found = *estimate_gradients(mesh, values_of(mesh, quadratic));
    EXPECT_LT(worst(mesh, found,
                    [](Vec2 p) {
                        return Vec2{2e-4 * p.x + p.y, p.x - 2 * p.y};
                    }),
              1e-6);  // coordinates have 1e-10 of the cell's width
}

TEST(PsGradients, ThirdOrderOnSmoothData) {
    std::array<double, 2> errors{};
    for (const int fine : {0, 1}) {
        const Triangulation mesh = shaken_square(fine ? 101 : 51, 0.4);
        const Vec2 origin = mesh.origin;
        const auto f = [&](Vec2 p) { return test::franke(p.x + origin.x, p.y + origin.y).value; };
        const auto found = *estimate_gradients(mesh, values_of(mesh, f));
        double sum = 0;
        for (Index v = 0; v < mesh.vertex_count(); ++v) {
            const Vec2 p = mesh.vertex(v) + origin;
            const auto truth = test::franke(p.x, p.y);
            const Vec2 off = found[v] - Vec2{truth.x, truth.y};
            sum += dot(off, off);
        }
        errors[static_cast<std::size_t>(fine)] = std::sqrt(sum / mesh.vertex_count());
    }
    // Cubics through the vertex: the error of gradients is of order h^3.
    EXPECT_GT(errors[0] / errors[1], 6.5) << errors[0] << " " << errors[1];
    EXPECT_LT(errors[1], 1e-3);
}

TEST(PsGradients, NoiseMakesFlatPlanes) {
    const Triangulation mesh = shaken_square(40, 0.4);
    std::mt19937 random(7);
    std::vector<double> values(mesh.vertex_count());
    for (double& z : values) z = random() / 4294967295.0 - 0.5;
    const auto found = *estimate_gradients(mesh, values, {GradientRule::Adaptive, 0, 1});
    const auto quadratic = *estimate_gradients(mesh, values, {GradientRule::Quadratic, 0, 0});
    const auto rms = [](const std::vector<Vec2>& g) {
        double sum = 0;
        for (const Vec2& v : g) sum += dot(v, v);
        return std::sqrt(sum / static_cast<double>(g.size()));
    };
    // Independent values have no slope to be found: the blend keeps far less of it.
    EXPECT_LT(rms(found), 0.5 * rms(quadratic));
}

TEST(PsGradients, TheLimitKeepsPlanesNearTheRangeOfTheirNeighbours) {
    const Triangulation mesh = shaken_square(12, 0.45, 3);
    std::vector<double> values(mesh.vertex_count(), 0);
    std::mt19937 random(5);
    for (double& z : values) z = random() % 17 == 0 ? 100 : 0.01 * (random() % 10);
    const auto found = *estimate_gradients(mesh, values);
    const auto neighbours = mesh::vertex_neighbours(mesh);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        double low = values[v];
        double high = values[v];
        for (const Index w : neighbours.of(v)) {
            low = std::min(low, values[w]);
            high = std::max(high, values[w]);
        }
        const double range = high - low;
        for (const Index w : neighbours.of(v)) {
            const double half = values[v] + 0.5 * dot(found[v], mesh.vertex(w) - mesh.vertex(v));
            EXPECT_GE(half, low - range * (1 + 1e-12));
            EXPECT_LE(half, high + range * (1 + 1e-12));
        }
    }
}

TEST(PsGradients, SmallAndDegenerateStencils) {
    // One triangle: the plane through it, to the accuracy of the slight flattening (1e-12).
    const auto one =
        mesh::build(std::vector<Vec2>{{0, 0}, {1, 0}, {0, 1}}, std::vector<Triangle>{{0, 1, 2}});
    const auto plane = *estimate_gradients(*one, std::vector<double>{1, 3, 0});
    for (const Vec2& g : plane) {
        EXPECT_NEAR(g.x, 2, 1e-10);
        EXPECT_NEAR(g.y, -1, 1e-10);
    }
    const auto constant = *estimate_gradients(*one, std::vector<double>{5, 5, 5});
    for (const Vec2& g : constant) EXPECT_EQ(g, (Vec2{0, 0}));
}

/// A wheel: its hub is a neighbour of everybody.
TEST(PsGradients, AHubOfManySpokesCostsNoMoreThanOthers) {
    const Index spokes = 200000;
    std::vector<Vec2> vertices{{0, 0}};
    std::vector<Triangle> triangles;
    for (Index k = 0; k < spokes; ++k) {
        const double angle = 2 * 3.14159265358979323846 * k / spokes;
        const double radius = 1 + 0.1 * (k % 2);
        vertices.push_back({radius * std::cos(angle), radius * std::sin(angle)});
        triangles.push_back({0, 1 + k, 1 + (k + 1) % spokes});
    }
    const auto mesh = mesh::build(vertices, triangles);
    ASSERT_TRUE(mesh.ok()) << mesh.error().text();
    const auto found =
        estimate_gradients(*mesh, values_of(*mesh, [](Vec2 p) { return p.x + 2 * p.y; }));
    ASSERT_TRUE(found.ok());
    EXPECT_NEAR((*found)[0].x, 1, 1e-9);
    EXPECT_NEAR((*found)[0].y, 2, 1e-9);
}

TEST(PsGradients, SameBitsForAnyThreadCountAndInstructionSet) {
    const Triangulation mesh = shaken_square(61, 0.4);
    const auto f = [&](Vec2 p) { return test::franke(p.x + 0.5, p.y + 0.5).value; };
    const std::vector<double> values = values_of(mesh, f);
    set_thread_count(1);
    const auto expected = *estimate_gradients(mesh, values);
    set_thread_count(3);
    EXPECT_EQ(*estimate_gradients(mesh, values), expected);
    set_thread_count(0);
    set_simd_enabled(false);
    EXPECT_EQ(*estimate_gradients(mesh, values), expected);
    set_simd_enabled(true);
}

TEST(PsGradients, BadInputIsNamed) {
    const Triangulation mesh = shaken_square(3, 0);
    std::vector<double> values(9, 0);
    EXPECT_EQ(estimate_gradients(mesh, std::span(values).first(8)).error().message.substr(0, 13),
              "size_mismatch");
    values[4] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(estimate_gradients(mesh, values).error().where, "vertex 4");
    values[4] = 0;
    EXPECT_EQ(estimate_gradients(mesh, values, {GradientRule::Adaptive, -1, 1}).error().code,
              ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace relief::multires::ps
