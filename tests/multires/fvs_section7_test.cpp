#include <functional>

#include "multires/fvs_mesh_support.h"

namespace relief::multires::fvs_mesh {
namespace {

using spline::PlaneJet;
using test::unit_square;

struct Errors {
    double largest = 0;
    double mean_square = 0;
};

template <class Reference>
Errors errors(const Hierarchy& hierarchy, int level, const NodalData& data,
              const std::vector<Vec2>& points, const Reference& reference) {
    const auto jets = test::jets(hierarchy, level, data, points);
    Errors e;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const double d = std::abs(jets[k].value - reference(k));
        e.largest = std::max(e.largest, d);
        e.mean_square += d * d / static_cast<double>(points.size());
    }
    return e;
}

using Function = std::function<PlaneJet(Vec2)>;

/// Thresholding at level 6 (section 7 of the paper).
void expect_section7(const nlohmann::json& cases, const Function& f) {
    ASSERT_FALSE(cases.empty());
    const Hierarchy hierarchy = unit_square(6);
    const NodalData spline = interpolate(hierarchy.mesh(6), f);
    const Decomposition full = *decompose(hierarchy, spline);
    const auto points = test::square_points(101);
    const auto full_jets = test::jets(hierarchy, 6, spline, points);
    for (const auto& row : cases) {
        const bool text = row["convention"] == "text";
        Decomposition kept = full;
        const auto counts = threshold(
            kept,
            threshold_limits(hierarchy, row["eps"], text ? Convention::Text : Convention::Const));
        EXPECT_EQ(counts, row["kept_by_level"].get<std::vector<std::uint64_t>>()) << row;
        const NodalData data = *reconstruct(hierarchy, kept, 6);
        const Errors e =
            errors(hierarchy, 6, data, points, [&](std::size_t k) { return f(points[k]).value; });
        const double e_inf = row["e_inf"];
        const double mean_square = row["mean_square"];
        const double to_spline = row["e_inf_vs_spline"];
        EXPECT_NEAR(e.largest, e_inf, 1e-10 * e_inf) << row;
        EXPECT_NEAR(e.mean_square, mean_square, 1e-10 * mean_square) << row;
        EXPECT_NEAR(
            errors(hierarchy, 6, data, points, [&](std::size_t k) { return full_jets[k].value; })
                .largest,
            to_spline, 1e-10 * to_spline)
            << row;
    }
}

TEST(FvsSection7, Franke) {
    expect_section7(test::fvs_golden()["section7_f1_franke"],
                    [](Vec2 p) { return test::franke(p); });
}

TEST(FvsSection7, FrankeWithSquare) {
    expect_section7(test::fvs_golden()["section7_f1_squared_variant"],
                    [](Vec2 p) { return test::franke(p, true); });
}

TEST(FvsSection7, Hill) {
    expect_section7(test::fvs_golden()["section7_f2"], test::hill);
}

void expect_level_errors(const nlohmann::json& cases, const Function& f) {
    const Hierarchy hierarchy = unit_square(6);
    const auto points = test::square_points(129);
    ASSERT_EQ(cases.size(), 7u);
    for (const auto& row : cases) {
        const int level = row["level"];
        const NodalData data = interpolate(hierarchy.mesh(level), f);
        EXPECT_EQ(3 * data.value.size() + data.normal.size(), row["dim"].get<std::size_t>());
        const Errors e = errors(hierarchy, level, data, points,
                                [&](std::size_t k) { return f(points[k]).value; });
        const double e_inf = row["e_inf"];
        const double mean_square = row["mean_square"];
        // Relative to the error, and a few roundings of the values of order 1.
        EXPECT_NEAR(e.largest, e_inf, 1e-10 * e_inf + 1e-15) << row;
        EXPECT_NEAR(e.mean_square, mean_square, 1e-10 * mean_square) << row;
    }
}

TEST(FvsSection7, LevelErrorsOfFranke) {
    expect_level_errors(test::fvs_golden()["level_errors_franke"],
                        [](Vec2 p) { return test::franke(p); });
}

TEST(FvsSection7, LevelErrorsOfHill) {
    expect_level_errors(test::fvs_golden()["level_errors_f2"], test::hill);
}

/// The hill is symmetric, so kept details come in fours, but for the value at the centre.
TEST(FvsSection7, HillIsInvariantUnderQuarterTurns) {
    const Hierarchy hierarchy = unit_square(6);
    const Decomposition full = *decompose(hierarchy, interpolate(hierarchy.mesh(6), test::hill));
    for (const double epsilon : {0.0005, 0.001, 0.0023, 0.005, 0.01}) {
        Decomposition kept = full;
        const auto counts = threshold(kept, threshold_limits(hierarchy, epsilon, Convention::Text));
        EXPECT_EQ(counts[1], 1u);
        EXPECT_NEAR(kept.details[0].centre_value[0], std::exp(-1), 1e-3);
        for (std::size_t m = 2; m < counts.size(); ++m) EXPECT_EQ(counts[m] % 4, 0u);
    }
}

}  // namespace
}  // namespace relief::multires::fvs_mesh
