#include "relief/multires/curve.h"

#include <gtest/gtest.h>

#include "multires/mesh_support.h"

namespace relief::multires {
namespace {

using test::distance;
using test::noisy;
using test::Points;
using test::points_of;

std::string name_of(std::size_t count, const CurveOptions& options) {
    return std::to_string(count) + " points, split " +
           std::to_string(static_cast<int>(options.split)) + ", ends " +
           std::to_string(static_cast<int>(options.ends)) + ", reversal " +
           std::to_string(static_cast<int>(options.reversal));
}

/// All curves that there are.
std::vector<std::pair<std::size_t, CurveOptions>> all_curves() {
    std::vector<std::pair<std::size_t, CurveOptions>> curves;
    for (std::size_t count = 2; count < 24; ++count)
        for (const CurveSplit split : {CurveSplit::Dyadic, CurveSplit::Ternary})
            for (const CurveEnds ends : {CurveEnds::Closed, CurveEnds::Natural, CurveEnds::Knots})
                for (const CurveReversal reversal :
                     {CurveReversal::LeastSquares, CurveReversal::Local, CurveReversal::Wide,
                      CurveReversal::Paper}) {
                    const CurveOptions options{split, ends, reversal};
                    if (CurveStep::create(count, options).ok()) curves.emplace_back(count, options);
                }
    return curves;
}

TEST(Curve, ReferenceVectors) {
    const auto golden = test::reference("reverse_subdivision.json");
    const double close = golden["tolerances"]["curves"];
    EXPECT_EQ(golden["curves"].size(), 14U);
    for (const auto& record : golden["curves"]) {
        CurveOptions options;
        options.split = record["arity"] == 2 ? CurveSplit::Dyadic : CurveSplit::Ternary;
        options.ends = record["closed"]              ? CurveEnds::Closed
                       : record["ends"] == "natural" ? CurveEnds::Natural
                                                     : CurveEnds::Knots;
        const CurveStep step = *CurveStep::create(record["n_coarse"], options);
        const Points g = points_of(record["g"]);
        const auto found = step.analyse(g);
        EXPECT_LT(distance(found.coarse, points_of(record["ls_c"])), close);
        EXPECT_LT(distance(found.details, points_of(record["ls_d"])), close);
        EXPECT_LT(distance(step.synthesise(found), g), close);
    }
}

TEST(Curve, KnotsOfTheSourcePaper) {
    const auto golden = test::reference("reverse_subdivision.json")["knots_P"];
    for (std::size_t count = 4; count <= 7; ++count) {
        const auto rows = test::grid_of(golden[std::to_string(count)]);
        const CurveStep step = *CurveStep::create(count, {.ends = CurveEnds::Knots});
        ASSERT_EQ(static_cast<std::int64_t>(step.fine_count()), rows.rows());
        for (std::int64_t i = 0; i < rows.rows(); ++i) {
            std::vector<double> row(count, 0);
            for (const auto& w : step.subdivision()[static_cast<std::size_t>(i)])
                row[w.point] += w.weight;
            for (std::int64_t k = 0; k < rows.cols(); ++k)
                EXPECT_NEAR(row[static_cast<std::size_t>(k)], rows(i, k), 1e-15) << i << " " << k;
        }
    }
    // Row 4 of nine points, section 6.2.
    const CurveStep nine = *CurveStep::create(9, {.ends = CurveEnds::Knots});
    EXPECT_NEAR(nine.subdivision()[3][2].weight, 1871.0 / 8800, 1e-16);
    EXPECT_NEAR(nine.subdivision()[5][1].weight, 97.0 / 176, 1e-15);
}

TEST(Curve, RulesAreTheReferences) {
    const auto golden = test::reference("reverse_subdivision.json")["closed_ternary"];
    const auto compare = [&](const char* name, const auto& ours, bool reversed = false) {
        ASSERT_EQ(golden[name].size(), ours.size());
        for (std::size_t k = 0; k < ours.size(); ++k)
            EXPECT_EQ(ours[reversed ? ours.size() - 1 - k : k].value(),
                      test::rational(golden[name][k]))
                << name << " " << k;
    };
    compare("A_width1", rules::kTernaryReversal);
    compare("A_width4", rules::kPaperReversal);
    compare("q", rules::kPaperCorrection, true);
    compare("b", rules::kPaperDetail);
}

/// The curves of surfaces have the same rules.
TEST(Curve, RulesOfSurfaces) {
    const auto same = [](const auto& reversal, const rules::CurveRule& curve) {
        EXPECT_NEAR(reversal[0].value(), 1 / curve.self, 1e-15);
        EXPECT_NEAR(reversal[1].value(), -curve.point / curve.self, 1e-15);
    };
    same(rules::kDyadicReversal, rules::kDyadicCurve);
    same(rules::kTernaryReversal, rules::kTernaryCurve);
    EXPECT_EQ(rules::kDyadicCurveMask[0].value(), rules::kDyadicMask.self);
    EXPECT_EQ(rules::kDyadicCurveMask[1].value(), rules::kSharpEdgeEnd);
    EXPECT_EQ(rules::kDyadicCurveMask[2].value(), rules::kDyadicMask.point);
    EXPECT_EQ(rules::kTernaryCurveMask[0].value(), rules::kTernaryMask.self);
    EXPECT_EQ(rules::kTernaryCurveMask[1].value(), rules::kThirdNear);
    EXPECT_EQ(rules::kTernaryCurveMask[2].value(), rules::kThirdFar);
    EXPECT_EQ(rules::kTernaryCurveMask[3].value(), rules::kTernaryMask.point);
    EXPECT_EQ(rules::kTernaryCurveMask[4].value(), rules::kThirdBeyond);
}

/// AP = I, BP = 0.
TEST(Curve, SubdivisionIsUndone) {
    for (const auto& [count, options] : all_curves()) {
        const CurveStep step = *CurveStep::create(count, options);
        const Points c = noisy(Points(count), 3, 1);
        const auto found = step.analyse(step.subdivide(c));
        EXPECT_LT(distance(found.coarse, c), 1e-13) << name_of(count, options);
        for (const auto& d : found.details) ASSERT_LT(length(d), 1e-13) << name_of(count, options);
    }
}

/// PA + QB = I, critically sampled.
TEST(Curve, PerfectReconstruction) {
    for (const auto& [count, options] : all_curves()) {
        const CurveStep step = *CurveStep::create(count, options);
        const Points g = noisy(Points(step.fine_count()), 4, 1);
        const auto found = step.analyse(g);
        EXPECT_EQ(found.coarse.size() + found.details.size(), g.size());
        EXPECT_LT(distance(step.synthesise(found), g), 1e-13) << name_of(count, options);
    }
}

/// AQ = 0, BQ = I: any details come back, and leave the coarse points alone.
TEST(Curve, DetailsComeBack) {
    for (const auto& [count, options] : all_curves()) {
        const CurveStep step = *CurveStep::create(count, options);
        const Points c = noisy(Points(count), 3, 1);
        const Points d = noisy(Points(step.fine_count() - count), 5, 1);
        const auto found = step.analyse(step.synthesise<Vec3<double>>({c, d}));
        EXPECT_LT(distance(found.coarse, c), 1e-12) << name_of(count, options);
        EXPECT_LT(distance(found.details, d), 1e-12) << name_of(count, options);
    }
}

/// Numbers as well as vectors; constants and straight lines have no details.
TEST(Curve, StraightLines) {
    for (const auto& [count, options] : all_curves()) {
        if (options.ends != CurveEnds::Natural) continue;
        const CurveStep step = *CurveStep::create(count, options);
        const double spacing = options.split == CurveSplit::Dyadic ? 0.5 : 1.0 / 3;
        std::vector<double> line;
        for (std::size_t i = 0; i < step.fine_count(); ++i)
            line.push_back(1 + spacing * static_cast<double>(i));
        const auto found = step.analyse(line);
        for (std::size_t k = 0; k < count; ++k)
            ASSERT_NEAR(found.coarse[k], 1.0 + static_cast<double>(k), 1e-13);
        for (const double d : found.details) ASSERT_NEAR(d, 0, 1e-13);
    }
}

/// The table of section 6.1: what white noise becomes.
TEST(Curve, NoiseGains) {
    struct Gain {
        CurveSplit split;
        CurveReversal reversal;
        double gain;
    };
    const Gain gains[] = {{CurveSplit::Ternary, CurveReversal::Local, 4.123},
                          {CurveSplit::Ternary, CurveReversal::Wide, 2.290},
                          {CurveSplit::Ternary, CurveReversal::Paper, 1.482},
                          {CurveSplit::Ternary, CurveReversal::LeastSquares, 1.141},
                          {CurveSplit::Dyadic, CurveReversal::Local, 2.121},
                          {CurveSplit::Dyadic, CurveReversal::LeastSquares, 1.210}};
    for (const Gain& gain : gains) {
        const CurveStep step =
            *CurveStep::create(40, {.split = gain.split, .reversal = gain.reversal});
        double sum = 0;  // squares of the row of A of one coarse point
        for (std::size_t i = 0; i < step.fine_count(); ++i) {
            std::vector<double> impulse(step.fine_count(), 0);
            impulse[i] = 1;
            const double weight = step.analyse(impulse).coarse[7];
            sum += weight * weight;
        }
        EXPECT_NEAR(std::sqrt(sum), gain.gain, 6e-4);  // the table's digits
    }
}

TEST(Curve, Refusals) {
    const auto refused = [](std::size_t count, const CurveOptions& options) {
        const auto made = CurveStep::create(count, options);
        return !made.ok() && made.error().message.rfind("invalid_parameter: ", 0) == 0;
    };
    EXPECT_TRUE(refused(2, {}));
    EXPECT_TRUE(refused(1, {.ends = CurveEnds::Natural}));
    EXPECT_TRUE(refused(3, {.ends = CurveEnds::Knots}));
    EXPECT_TRUE(refused(9, {.ends = CurveEnds::Knots, .reversal = CurveReversal::Local}));
    EXPECT_TRUE(refused(9, {.split = CurveSplit::Dyadic, .ends = CurveEnds::Knots}));
    EXPECT_TRUE(refused(9, {.ends = CurveEnds::Natural, .reversal = CurveReversal::Paper}));
    EXPECT_TRUE(refused(9, {.split = CurveSplit::Dyadic, .reversal = CurveReversal::Wide}));
}

}  // namespace
}  // namespace relief::multires
