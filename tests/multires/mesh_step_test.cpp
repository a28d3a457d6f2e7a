#include "relief/multires/mesh_step.h"

#include <gtest/gtest.h>

#include "multires/mesh_support.h"

namespace relief::multires {
namespace {

using mesh::Index;
using mesh::Split;
using mesh::Topology;
using test::all_levels;
using test::distance;
using test::Level;
using test::level_of;
using test::noisy;
using test::Points;
using test::points_of;

TEST(SubdivisionRules, ReferenceTables) {
    const auto tables = test::reference("reverse_subdivision.json")["tables"];
    constexpr double close = 1e-14;  // the tables' digits
    for (const auto& row : tables["sqrt3"]) {
        const Index n = row[0];
        const auto rule = rules::sqrt3_smooth(n, rules::sqrt3_alpha(n));
        EXPECT_NEAR(rules::sqrt3_alpha(n), row[1].get<double>(), close);
        EXPECT_NEAR(rule.self, row[2].get<double>(), close);
        EXPECT_NEAR(rule.face, row[3].get<double>(), close);
    }
    for (const auto& row : tables["loop"]) {
        const Index n = row[0];
        EXPECT_NEAR(rules::loop_alpha(n), row[1].get<double>(), close);
        EXPECT_NEAR(rules::loop_smooth(n).self, row[2].get<double>(), close);
        EXPECT_NEAR(rules::loop_smooth(n).edge, row[3].get<double>(), close);
    }
    for (const auto& row : tables["cc"]) {
        const auto rule = rules::catmull_clark_smooth(row[0]);
        EXPECT_NEAR(rule.self, row[1].get<double>(), close);
        EXPECT_NEAR(rule.edge, row[2].get<double>(), close);
        EXPECT_NEAR(rule.face, row[3].get<double>(), close);
    }
}

/// Both forms of the rules of curves say the same: new points are made of old ones.
TEST(SubdivisionRules, CurvesInBothForms) {
    using namespace rules;
    EXPECT_NEAR(kDyadicCurve.self + 2 * kDyadicCurve.point * kSharpEdgeEnd, kDyadicMask.self,
                1e-15);
    EXPECT_NEAR(kDyadicCurve.point * kSharpEdgeEnd, kDyadicMask.point, 1e-15);
    const double beside = kTernaryCurve.point * (kThirdFar + kThirdBeyond);
    EXPECT_NEAR(kTernaryCurve.self + 2 * kTernaryCurve.point * kThirdNear, kTernaryMask.self,
                1e-15);
    EXPECT_NEAR(beside, kTernaryMask.point, 1e-15);
}

/// D + (all of K) = 1: constants stay.
TEST(SubdivisionRules, WeightsAddUp) {
    for (Index n = 2; n < 40; ++n) {
        const auto loop = rules::loop_smooth(n);
        EXPECT_NEAR(loop.self + n * loop.edge, 1, 1e-14) << n;
        const auto quad = rules::catmull_clark_smooth(n);
        EXPECT_NEAR(quad.self + n * (quad.edge + quad.face), 1, 1e-14) << n;
        const auto dart = rules::loop_dart(n);
        double sum = dart.self;
        for (const double w : dart.edges) sum += w;
        EXPECT_NEAR(sum, 1, 1e-14) << n;
        if (n < 3) continue;
        const auto sqrt3 = rules::sqrt3_smooth(n, rules::sqrt3_alpha(n));
        EXPECT_NEAR(sqrt3.self + n * sqrt3.face, 1, 1e-14) << n;
    }
}

TEST(MeshStep, ReferenceVectors) {
    const auto golden = test::reference("reverse_subdivision.json");
    const double close = golden["tolerances"]["plain"];
    for (const auto& record : golden["decompositions"]) {
        const Level level = level_of(record);
        const Points coarse = points_of(record["coarse"]);
        EXPECT_LT(distance(level.subdivided(coarse), points_of(record["fine"])), close)
            << record["name"];
        const Points g = points_of(record["g"]);
        const auto [fine, residuals] = level.analysed(g);
        // Stiff vertices: the record has them apart, packed ones are tested with the packing.
        const bool stiff = record.contains("explicit");
        const auto& expected = stiff ? record["explicit"] : record["plain"];
        Points c(fine.begin(), fine.begin() + static_cast<long>(coarse.size()));
        Points d(fine.begin() + static_cast<long>(coarse.size()), fine.end());
        const auto& expected_c = expected.contains("c") ? expected["c"] : record["plain"]["c"];
        EXPECT_LT(distance(c, points_of(expected_c)), 10 * close) << record["name"];
        EXPECT_LT(distance(d, points_of(expected["d"])), 10 * close) << record["name"];
        if (stiff) {
            EXPECT_EQ(level.rules.stiff.vertices, expected["v3"].get<std::vector<Index>>());
            EXPECT_LT(distance(residuals, points_of(expected["r"])), 10 * close);
        }
        EXPECT_LT(distance(level.synthesised(fine, residuals), g), 1e-13) << record["name"];
    }
}

/// Rules by hand, section 14.
TEST(MeshStep, HandValues) {
    const Level cube(test::cube().topology(), {}, Split::CatmullClark);
    const Points quads = cube.subdivided(points_of(test::cube()));
    for (std::size_t v = 0; v < 8; ++v) EXPECT_NEAR(std::abs(quads[v].x), 5.0 / 9, 1e-15);
    for (std::size_t v = 8; v < 20; ++v)
        EXPECT_NEAR(length(quads[v]), std::sqrt(2 * 0.75 * 0.75), 1e-15);
    const Level loop(test::octahedron().topology(), {}, Split::Loop);
    const Points triangles = loop.subdivided(points_of(test::octahedron()));
    EXPECT_NEAR(triangles[0].x, 0.515625, 1e-15);
    EXPECT_NEAR(length(triangles[6]), std::sqrt(2.0) * 3 / 8, 1e-15);
    const Level sqrt3(test::octahedron().topology(), {}, Split::Sqrt3Odd);
    const Points kites = sqrt3.subdivided(points_of(test::octahedron()));
    EXPECT_NEAR(kites[0].x, 5.0 / 9, 1e-15);
    EXPECT_NEAR(std::abs(kites[6].y), 1.0 / 3, 1e-15);
}

/// AP = I, BP = 0.
TEST(MeshStep, SubdivisionIsUndone) {
    for (const auto& [name, level] : all_levels()) {
        Points c = noisy(Points(level.coarse.vertex_count), 3, 1);
        const auto [fine, residuals] = level.analysed(level.subdivided(c));
        const Points back(fine.begin(), fine.begin() + static_cast<long>(c.size()));
        EXPECT_LT(distance(back, c), 1e-12) << name;  // weights are at most 15
        for (std::size_t x = c.size(); x < fine.size(); ++x)
            ASSERT_LT(length(fine[x]), 1e-12) << name;
        for (const auto& r : residuals) ASSERT_LT(length(r), 1e-12) << name;
    }
}

/// PA + QB = I.
TEST(MeshStep, PerfectReconstruction) {
    for (const auto& [name, level] : all_levels()) {
        const Points g = noisy(Points(level.coarse.vertex_count + level.rules.new_count), 4, 1);
        const auto [fine, residuals] = level.analysed(g);
        EXPECT_LT(distance(level.synthesised(fine, residuals), g), 1e-13) << name;
    }
}

/// <P c, e> = <c, P^T e>, and constants stay.
TEST(MeshStep, AdjointAndConstants) {
    for (const auto& [name, level] : all_levels()) {
        const Points c = noisy(Points(level.coarse.vertex_count), 5, 1);
        Points e = noisy(Points(c.size() + level.rules.new_count), 6, 1);
        const Points fine = level.subdivided(c);
        Vec3<double> left;
        for (std::size_t k = 0; k < e.size(); ++k)
            left += {e[k].x * fine[k].x, e[k].y * fine[k].y, e[k].z * fine[k].z};
        Points image(c.size());
        level.step().adjoint(e.data(), e.data() + c.size(), image.data());
        Vec3<double> right;
        for (std::size_t k = 0; k < c.size(); ++k)
            right += {c[k].x * image[k].x, c[k].y * image[k].y, c[k].z * image[k].z};
        EXPECT_LT(length(left - right), 1e-11) << name;
        const Points ones = level.subdivided(Points(c.size(), {1, 2, 3}));
        for (const auto& p : ones) ASSERT_LT(length(p - Vec3<double>{1, 2, 3}), 1e-14) << name;
    }
}

/// Also with other weights of neighbours.
TEST(MeshStep, AlphaOfSqrt3) {
    const Level level(test::flipped(test::icosahedron(), 40, 1).topology(), {}, Split::Sqrt3Odd,
                      {.alpha = 0.125});
    EXPECT_EQ(level.rules.self[0], 1 - 1.5 * 0.125);
    const Points g = noisy(Points(level.coarse.vertex_count + level.rules.new_count), 4, 1);
    const auto [fine, residuals] = level.analysed(g);
    EXPECT_LT(distance(level.synthesised(fine, residuals), g), 1e-14);
    const Topology mesh = test::octahedron().topology();
    for (const double alpha : {-0.1, 2.0 / 3, std::nan("")}) {
        const auto rules = step_rules(mesh, {}, Split::Sqrt3Odd, {.alpha = alpha});
        ASSERT_FALSE(rules.ok());
        EXPECT_NE(rules.error().text().find("invalid_parameter"), std::string::npos);
    }
}

TEST(MeshStep, Refusals) {
    const Topology mesh = test::icosahedron().topology();
    MeshTags tags;
    tags.sharp.assign(mesh.edge_count, 0);
    tags.sharp[3] = 1;
    const auto sharp = step_rules(mesh, tags, Split::Sqrt3Odd);
    ASSERT_FALSE(sharp.ok());
    EXPECT_NE(sharp.error().text().find("invalid_parameter: sqrt(3) subdivision has no sharp"),
              std::string::npos);
    EXPECT_FALSE(step_rules(test::cube().topology(), {}, Split::Loop).ok());
    tags.sharp.pop_back();
    EXPECT_FALSE(step_rules(mesh, tags, Split::Loop).ok());
}

/// A cube and its component's alternating vector, which P loses.
TEST(MeshStep, CubicBipartiteMeshes) {
    const Level cube(test::cube().topology(), {}, Split::CatmullClark);
    ASSERT_EQ(cube.rules.stiff.alternating.size(), 1U);
    Points alternating(8);
    const auto& component = cube.rules.stiff.alternating[0];
    for (std::size_t k = 0; k < 8; ++k)
        alternating[cube.rules.stiff.vertices[component.places[k]]].x = component.signs[k];
    for (const auto& p : cube.subdivided(alternating)) EXPECT_LT(length(p), 1e-15);
    const Level tetrahedron(test::tetrahedron().topology(), {}, Split::CatmullClark);
    EXPECT_EQ(tetrahedron.rules.stiff.size(), 4U);
    EXPECT_TRUE(tetrahedron.rules.stiff.alternating.empty());
}

}  // namespace
}  // namespace relief::multires
