#include "relief/multires/ps_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "franke.h"
#include "relief/core/parallel.h"
#include "relief/mesh/delaunay.h"
#include "relief/mesh/triangle_locator.h"
#include "relief/multires/ps_energy.h"
#include "support.h"

namespace relief::multires::ps {
namespace {

using mesh::Index;

/// A spline space over vertices of the unit square, and data in it.
struct Scene {
    Space space;
    std::vector<Vec2> points;
    std::vector<Index> triangles;

    /// side x side vertices, moved off a lattice: triangles without very small angles.
    Scene(int side, int data, std::uint64_t seed = 1) {
        test::Noise noise(seed);
        std::vector<Vec2> corners;
        for (int r = 0; r < side; ++r)
            for (int c = 0; c < side; ++c) {
                const double dx = c > 0 && c + 1 < side ? 0.25 * noise() : 0;
                const double dy = r > 0 && r + 1 < side ? 0.25 * noise() : 0;
                corners.push_back({(c + dx) / (side - 1), (r + dy) / (side - 1)});
            }
        auto delaunay = mesh::delaunay(corners);
        space = *make_space(std::move(delaunay->mesh));
        const mesh::TriangleLocator locator(space.mesh);
        while (static_cast<int>(points.size()) < data) {
            const Vec2 p{0.5 + 0.5 * noise(), 0.5 + 0.5 * noise()};
            const Index t = locator.locate(p);
            if (t == mesh::kNone) continue;
            points.push_back(p);
            triangles.push_back(t);
        }
    }

    [[nodiscard]] DataSites sites(std::span<const double> weights = {}) const {
        return {points, triangles, weights};
    }
    template <class F>
    [[nodiscard]] std::vector<double> values(F&& f) const {
        std::vector<double> z;
        for (const Vec2& p : points) z.push_back(f(p));
        return z;
    }
};

double quadratic(Vec2 p) {
    return 1 + p.x - 2 * p.y + 3 * p.x * p.x - p.x * p.y + 2 * p.y * p.y;
}
double linear(Vec2 p) {
    return 1 + 3 * p.x - 2 * p.y;
}

/// The quadratic as a spline of the space, whose origin is not that of the points.
Coefficients exact_quadratic(const Space& space) {
    TangentPlanes planes;
    for (Index v = 0; v < space.mesh.vertex_count(); ++v) {
        const Vec2 p = space.mesh.vertex(v) + space.mesh.origin;
        planes.push_back({quadratic(p), {1 + 6 * p.x - p.y, -2 - p.x + 4 * p.y}});
    }
    return coefficients(space, planes);
}

double energy_of(const BlockMatrix& matrix, const Coefficients& spline) {
    const Coefficients image = matrix.times(spline);
    double sum = 0;
    for (std::size_t v = 0; v < spline.size(); ++v)
        for (std::size_t j = 0; j < 3; ++j) sum += spline[v][j] * image[v][j];
    return sum;
}

TEST(PsFit, EnergiesOfAQuadratic) {
    const Scene scene(7, 1);
    const Coefficients spline = exact_quadratic(scene.space);
    double area = 0;
    for (Index t = 0; t < scene.space.mesh.triangle_count(); ++t) {
        const auto [a, b, c] = scene.space.mesh.corners(t);
        area += 0.5 * cross(b - a, c - a);
    }
    const double plate = energy_of(thin_plate_matrix(scene.space), spline);
    // Second derivatives 6, -1 and 4; section 14 asks for 1e-9.
    EXPECT_NEAR(plate / (area * (36 + 2 + 16)), 1, 1e-9);
    // Zero but for cancellation among squares, which are as large as the plate's energy.
    EXPECT_LT(std::abs(energy_of(jump_matrix(scene.space), spline)), 1e-9 * plate);
}

TEST(PsFit, QuadraticsWithoutSmoothing) {
    const Scene scene(7, 3000);
    const auto fit =
        LeastSquares::create(scene.space, scene.sites())->fit(scene.values(quadratic), 0.0);
    ASSERT_TRUE(fit.ok()) << fit.error().text();
    EXPECT_LT(fit->report.max_error, 1e-9);
    const Coefficients expected = exact_quadratic(scene.space);
    for (std::size_t v = 0; v < expected.size(); ++v)
        for (std::size_t j = 0; j < 3; ++j)
            EXPECT_NEAR(fit->spline[v][j], expected[v][j], 1e-9) << v;
}

TEST(PsFit, WhatEnergiesDoNotPenaliseIsReproduced) {
    const Scene scene(7, 3000);
    const auto plate =
        LeastSquares::create(scene.space, scene.sites())->fit(scene.values(linear), 1.0);
    EXPECT_LT(plate->report.max_error, 1e-9);
    const auto jump = LeastSquares::create(scene.space, scene.sites(), Energy::Jump)
                          ->fit(scene.values(quadratic), 1.0);
    EXPECT_LT(jump->report.max_error, 1e-7);  // section 14: the condition number
}

TEST(PsFit, CrossValidationFindsTheNoise) {
    const Scene scene(7, 3000);
    test::Noise noise(9);
    // Noise of root mean square 0.02.
    const auto z = scene.values(
        [&](Vec2 p) { return test::franke(p.x, p.y).value + 0.02 * std::sqrt(3.0) * noise(); });
    for (const Energy energy : {Energy::ThinPlate, Energy::Jump}) {
        const auto squares = LeastSquares::create(scene.space, scene.sites(), energy);
        const auto fit = squares->fit(z);
        ASSERT_TRUE(fit.ok());
        std::vector<double> at(z.size());
        squares->evaluate(fit->spline, at);
        const auto true_error = [&](const std::vector<double>& found) {
            double sum = 0;
            for (std::size_t k = 0; k < found.size(); ++k) {
                const Vec2 p = scene.points[k];
                const double off = found[k] - test::franke(p.x, p.y).value;
                sum += off * off;
            }
            return std::sqrt(sum / static_cast<double>(found.size()));
        };
        const double chosen = true_error(at);
        EXPECT_GT(fit->report.smoothing, 0.9e-12);
        // Within 5 % of the best of all the powers that it chose from (section 12).
        double best = chosen;
        for (double mu = 1e-12; mu < 2e-3; mu *= 10) {
            squares->evaluate(squares->fit(z, mu)->spline, at);
            best = std::min(best, true_error(at));
        }
        EXPECT_LT(chosen, 1.05 * best);
    }
}

TEST(PsFit, WeightsCountAsRepeatedPoints) {
    const Scene scene(5, 400);
    const auto f = [](Vec2 p) { return test::franke(p.x, p.y).value; };
    std::vector<double> weights(scene.points.size(), 1);
    Scene twice = scene;
    for (std::size_t k = 0; k < weights.size(); k += 3) {
        weights[k] = 2;
        twice.points.push_back(scene.points[k]);
        twice.triangles.push_back(scene.triangles[k]);
    }
    const auto weighted =
        LeastSquares::create(scene.space, scene.sites(weights))->fit(scene.values(f), 1e-6);
    const auto repeated =
        LeastSquares::create(scene.space, twice.sites())->fit(twice.values(f), 1e-6);
    EXPECT_NEAR(weighted->report.rms_error, repeated->report.rms_error, 1e-12);
    for (std::size_t v = 0; v < weighted->spline.size(); ++v)
        EXPECT_NEAR(weighted->spline[v][0], repeated->spline[v][0], 1e-9);
}

TEST(PsFit, WithoutDataThereIsTheTrend) {
    // Data in the left half only, far above zero: next to nothing of the smoothing is left.
    Scene scene(9, 2000);
    Scene left = scene;
    left.points.clear();
    left.triangles.clear();
    for (std::size_t k = 0; k < scene.points.size(); ++k) {
        if (scene.points[k].x > 0.5) continue;
        left.points.push_back(scene.points[k]);
        left.triangles.push_back(scene.triangles[k]);
    }
    const auto far_linear = [](Vec2 p) { return 1000 + linear(p); };
    const auto far_quadratic = [](Vec2 p) { return 1000 + quadratic(p); };
    std::vector<double> at(scene.points.size());
    const auto worst = [&](Energy energy, const std::vector<double>& known,
                           const std::vector<double>& expected) {
        const auto fit = LeastSquares::create(left.space, left.sites(), energy)->fit(known, 1e-30);
        LeastSquares::create(scene.space, scene.sites())->evaluate(fit->spline, at);
        double most = 0;
        for (std::size_t k = 0; k < at.size(); ++k)
            most = std::max(most, std::abs(at[k] - expected[k]));
        return most;
    };
    // Coefficients of polynomials that an extrapolation by the width of the data does not shake.
    EXPECT_LT(worst(Energy::ThinPlate, left.values(far_linear), scene.values(far_linear)), 1e-8);
    EXPECT_LT(worst(Energy::Jump, left.values(far_quadratic), scene.values(far_quadratic)), 1e-8);
}

TEST(PsFit, SameBitsForAnyThreadCount) {
    const Scene scene(17, 5000);
    const auto z = scene.values([](Vec2 p) { return test::franke(p.x, p.y).value; });
    set_thread_count(1);
    const auto expected = LeastSquares::create(scene.space, scene.sites())->fit(z);
    set_thread_count(3);
    const auto again = LeastSquares::create(scene.space, scene.sites())->fit(z);
    set_thread_count(0);
    EXPECT_EQ(again->spline, expected->spline);
    EXPECT_EQ(again->report.smoothing, expected->report.smoothing);
}

TEST(PsFit, BadInputIsNamed) {
    const Scene scene(7, 5);
    const auto squares = LeastSquares::create(scene.space, scene.sites());
    std::vector<double> z(5, 1);
    // Five points do not determine 147 numbers.
    EXPECT_EQ(squares->fit(z, 0.0).error().message.substr(0, 15), "singular_system");
    const std::vector<Vec2> line{{0.1, 0.1}, {0.2, 0.2}, {0.4, 0.4}};
    const std::vector<Index> where(3, 0);
    // Whatever the triangles: a plane through a line is not determined, smoothing or not.
    const auto thin = LeastSquares::create(scene.space, {line, where, {}});
    EXPECT_EQ(thin->fit(std::span(z).first(3), 1.0).error().where, "points");
    EXPECT_EQ(squares->fit(std::span(z).first(4), 1.0).error().message.substr(0, 13),
              "size_mismatch");
    EXPECT_EQ(squares->fit(z, -1.0).error().code, ErrorCode::InvalidArgument);
    z[3] = std::numeric_limits<double>::infinity();
    EXPECT_EQ(squares->fit(z, 1.0).error().where, "point 3");
    const std::vector<double> none(5, 0);
    EXPECT_EQ(LeastSquares::create(scene.space, scene.sites(none)).error().message.substr(0, 7),
              "no_data");
    const std::vector<double> negative{1, 1, -1, 1, 1};
    EXPECT_EQ(LeastSquares::create(scene.space, scene.sites(negative)).error().where, "point 2");
}

}  // namespace
}  // namespace relief::multires::ps
