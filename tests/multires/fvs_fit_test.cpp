#include <limits>

#include "multires/fvs_mesh_support.h"
#include "relief/multires/fvs_mesh_coding.h"

namespace relief::multires::fvs_mesh {
namespace {

using mesh::Quadrangulation;
using test::built;
using test::hierarchy_of;
using test::largest_difference;
using test::unit_square;

std::vector<Vec2> random_points(const Quadrangulation& mesh, std::size_t a_quad) {
    test::Noise noise(41);
    std::vector<Vec2> points;
    for (mesh::Index q = 0; q < mesh.quad_count(); ++q) {
        const QuadCorners v = mesh.corners(q);
        for (std::size_t k = 0; k < a_quad; ++k) {
            const double s = 0.5 + 0.499 * noise();
            const double t = 0.5 + 0.499 * noise();
            const Vec2 low = v[0] + s * (v[1] - v[0]);
            points.push_back(mesh.origin + low + t * (v[3] + s * (v[2] - v[3]) - low));
        }
    }
    return points;
}

TEST(FvsFit, FindsTheSplineOfItsSamples) {
    for (const Quadrangulation& mesh :
         {built(test::grid_mesh(3, 3, 1, 0.15)), built(test::star_mesh(5)),
          built(test::without_quad(test::grid_mesh(3, 3), 4))}) {
        const Hierarchy hierarchy = hierarchy_of(mesh, 1);
        const NodalData exact = test::noise_data(hierarchy.mesh(1), 43);
        const auto points = random_points(hierarchy.mesh(1), 40);
        std::vector<double> values;
        for (const auto& jet : test::jets(hierarchy, 1, exact, points)) values.push_back(jet.value);
        const Fit found = *fit(hierarchy, 1, points, values, make_nodal<double>(hierarchy.mesh(1)));
        // The ridge, and the reduction of 1e-10 times the condition of the samples.
        EXPECT_LT(largest_difference(found.data, exact), 1e-5);
        EXPECT_LT(found.rms, 1e-8);
    }
}

TEST(FvsFit, BeatsInterpolationOnFranke) {
    struct Case {
        int level;
        int samples;                                          ///< a side
        double max_before, max_after, rms_before, rms_after;  ///< section 7
    };
    const auto check = test::square_points(129);
    for (const Case& c : {Case{3, 129, 8.3e-3, 2.4e-3, 1.07e-3, 2.5e-4},
                          Case{4, 129, 6.9e-4, 2.4e-4, 6.7e-5, 2.3e-5}}) {
        const Hierarchy hierarchy = unit_square(c.level);
        const NodalData start =
            interpolate(hierarchy.mesh(c.level), [](Vec2 p) { return test::franke(p); });
        const auto points = test::square_points(c.samples);
        std::vector<double> values;
        for (const Vec2 p : points) values.push_back(test::franke(p).value);
        const Fit found = *fit(hierarchy, c.level, points, values, start);
        const auto error = [&](const NodalData& data) {
            const auto jets = test::jets(hierarchy, c.level, data, check);
            std::pair<double, double> e{0, 0};
            for (std::size_t k = 0; k < check.size(); ++k) {
                const double d = std::abs(jets[k].value - test::franke(check[k]).value);
                e.first = std::max(e.first, d);
                e.second += d * d / static_cast<double>(check.size());
            }
            e.second = std::sqrt(e.second);
            return e;
        };
        const auto [max_before, rms_before] = error(start);
        const auto [max_after, rms_after] = error(found.data);
        // Two digits are printed, and the sample grid is not.
        EXPECT_NEAR(max_before, c.max_before, 0.02 * c.max_before);
        EXPECT_NEAR(rms_before, c.rms_before, 0.02 * c.rms_before);
        EXPECT_NEAR(max_after, c.max_after, 0.1 * c.max_after);
        EXPECT_NEAR(rms_after, c.rms_after, 0.05 * c.rms_after);
    }
}

TEST(FvsFit, KeepsTheStartWhereNothingIsKnown) {
    const Hierarchy hierarchy = hierarchy_of(built(test::grid_mesh(5, 1)), 0);
    const Quadrangulation& mesh = hierarchy.mesh(0);
    const NodalData start = test::noise_data(mesh, 47);
    const std::vector<Vec2> points = {{0.3, 0.4}, {0.8, 0.6}};
    const Fit found = *fit(hierarchy, 0, points, std::vector<double>{2, 3}, start);
    EXPECT_LT(found.rms, 1e-8);
    // Vertices 2 .. 5 and 8 .. 11 touch no quad with samples.
    for (const std::size_t v : {2u, 3u, 4u, 5u, 8u, 9u, 10u, 11u}) {
        EXPECT_EQ(found.data.value[v], start.value[v]);
        EXPECT_EQ(found.data.dx[v], start.dx[v]);
        EXPECT_EQ(found.data.dy[v], start.dy[v]);
    }
}

TEST(FvsFit, NamedErrors) {
    const Hierarchy hierarchy = unit_square(1);
    const NodalData start = make_nodal<double>(hierarchy.mesh(1));
    const std::vector<Vec2> points = {{0.5, 0.5}, {1.5, 0.5}};
    const std::vector<double> values = {1, 2};
    const auto name = [](const Error& error) {
        return error.message.substr(0, error.message.find(':'));
    };
    const auto outside = fit(hierarchy, 1, points, values, start);
    ASSERT_FALSE(outside.ok());
    EXPECT_EQ(name(outside.error()), "outside_domain");
    EXPECT_EQ(outside.error().where, "sample 1");
    EXPECT_EQ(name(fit(hierarchy, 1, {}, {}, start).error()), "no_samples");
    EXPECT_EQ(name(fit(hierarchy, 1, points, values, start, {.ridge = 0}).error()),
              "ridge_not_positive");
    EXPECT_EQ(name(fit(hierarchy, 1, points, {}, start).error()), "size_mismatch");
    EXPECT_EQ(name(fit(hierarchy, 0, points, values, start).error()), "size_mismatch");
    EXPECT_EQ(name(fit(hierarchy, 2, points, values, start).error()), "level_out_of_range");
    const std::vector<double> bad = {std::numeric_limits<double>::infinity(), 2};
    EXPECT_EQ(name(fit(hierarchy, 1, points, bad, start).error()), "non_finite_data");
}

}  // namespace
}  // namespace relief::multires::fvs_mesh
