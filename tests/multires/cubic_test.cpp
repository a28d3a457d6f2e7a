#include "relief/multires/cubic.h"

#include "cubic_reference.h"
#include "cubic_support.h"
#include "relief/core/parallel.h"
#include "relief/core/simd.h"
#include "support.h"

namespace relief::multires::cubic {
namespace {

using test::largest_difference;
using test::noise_grid;

/// Threads and vector instructions as they were, whatever a test did.
struct Settings {
    Settings() = default;
    Settings(const Settings&) = delete;
    Settings& operator=(const Settings&) = delete;
    ~Settings() {
        set_thread_count(0);
        set_simd_enabled(true);
    }
};

template <class T>
class CubicScheme : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(CubicScheme, Scalars);

TEST(Cubic, BandsHaveAsManyCoefficientsAsSamples) {
    const auto bands = *layout(spec_of(2), 13, 18, 3);
    ASSERT_EQ(bands.bands.size(), 7U);
    const std::pair<const char*, LatticeBox> expected[] = {
        {"scaling", {0, 0, 4, 5}}, {"odd-x", {0, 0, 4, 4}}, {"odd-y", {0, 0, 3, 5}},
        {"odd-xy", {0, 0, 3, 4}},  {"odd-x", {0, 0, 7, 9}}, {"odd-y", {0, 0, 6, 9}},
        {"odd-xy", {0, 0, 6, 9}}};
    for (std::size_t k = 0; k < 7; ++k) {
        EXPECT_EQ(bands.bands[k].name, expected[k].first);
        EXPECT_EQ(bands.bands[k].box, expected[k].second) << k;
        EXPECT_EQ(bands.bands[k].level, k < 4 ? 2 : 1);
        EXPECT_EQ(bands.bands[k].channel, k == 0 ? 0 : int(k - 1) % 3 + 1);
    }
    EXPECT_EQ(bands.coefficients(), 13 * 18);
    EXPECT_EQ(bands.components, 3);
}

TEST(Cubic, DefaultLevelsLeaveAtLeastFourSamplesASide) {
    const std::tuple<int, int, int> cases[] = {
        {7, 900, 0},      {8, 900, 1},  {15, 16, 1}, {16, 16, 2}, {600, 512, 7}, {511, 4096, 6},
        {9999, 12000, 7}, {1, 4096, 7}, {64, 1, 4},  {1, 1, 0},   {2, 4096, 0}};
    for (const auto& [rows, cols, levels] : cases)
        EXPECT_EQ(layout(spec_of(), rows, cols, 1)->levels(), levels) << rows << " x " << cols;
}

TEST(Cubic, RefusesWhatItCanNotDo) {
    const auto code = [](SchemeSpec spec, std::int64_t rows = 9, int components = 1) {
        spec.id = SchemeId::Cubic;
        return layout(spec, rows, 9, components).error().code;
    };
    EXPECT_EQ(code({.order = 1}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({.order = 3}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({.data_map = DataMap::Coefficients}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({.data_map = DataMap::QuasiInterpolate}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({.levels = 5}), ErrorCode::InvalidArgument) << "9 samples halve 4 times";
    EXPECT_EQ(code({.levels = -2}), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({}, 0), ErrorCode::BadInput);
    EXPECT_EQ(code({}, std::int64_t{1} << 31), ErrorCode::BadInput);
    EXPECT_EQ(code({}, 9, 5), ErrorCode::InvalidArgument);
    EXPECT_EQ(layout(spec_of(4), 9, 9, 1)->bands[0].box, (LatticeBox{0, 0, 1, 1}));
}

/// The reference's taps have ten digits: their sum is off by 2e-10, and that of two levels grows by
/// the sums of absolute taps.
TEST(Cubic, IsTheFormulasOfTheSpecification) {
    for (const auto& [rows, cols] : {std::pair{1, 1},
                                     {1, 2},
                                     {2, 1},
                                     {2, 2},
                                     {3, 5},
                                     {12, 7},
                                     {13, 30},
                                     {40, 41},
                                     {64, 3},
                                     {1, 50},
                                     {57, 1},
                                     {130, 201}}) {
        const auto finest = noise_grid<double>(rows, cols, std::uint64_t(rows * 100 + cols));
        const int most = std::max(rows, cols) > 8 ? 4 : std::max(rows, cols) > 1 ? 1 : 0;
        const auto pyramid = analysed(finest, spec_of(most));
        const auto expected = reference::analyse(finest, pyramid.layout);
        for (std::size_t k = 0; k < expected.size(); ++k)
            EXPECT_LT(largest_difference(expected[k], pyramid.bands[k][0]), 2e-8)
                << rows << " x " << cols << ' ' << k;
    }
}

/// Each level adds rounding errors of a few units in the last place; the largest sample is 1.
TYPED_TEST(CubicScheme, GivesEverySampleBack) {
    using T = TypeParam;
    const double tolerance = std::is_same_v<T, float> ? 1e-5 : 1e-12;
    const auto check = [&](std::int64_t rows, std::int64_t cols, const SchemeSpec& spec) {
        const auto finest = noise_grid<T>(rows, cols, std::uint64_t(rows * 1000 + cols));
        const auto back = coefficients(analysed(finest, spec), 0, 0);
        EXPECT_LT(largest_difference(finest, back), tolerance) << rows << " x " << cols;
    };
    const auto all_levels = [](std::int64_t rows, std::int64_t cols) {
        int levels = 0;
        while (std::max(rows, cols) > std::int64_t{1} << levels) ++levels;
        return levels;
    };
    for (const bool exact : {false, true}) {
        for (std::int64_t rows = 1; rows <= 40; ++rows)
            for (std::int64_t cols = 1; cols <= 40; ++cols)
                check(rows, cols, spec_of(all_levels(rows, cols), exact));
        for (const auto& [rows, cols] :
             {std::pair{97, 131}, {1, 777}, {515, 3}, {257, 300}, {530, 71}, {19, 4200}})
            check(rows, cols, spec_of(-1, exact));
    }
}

/// Tiles are 512 x 4096 samples; the raster has several.
TYPED_TEST(CubicScheme, BytesDoNotDependOnThreadsOrInstructions) {
    using T = TypeParam;
    const Settings settings;
    for (const auto& [rows, cols] : {std::pair{1100, 45}, {33, 4200}, {530, 61}})
        for (const bool exact : {false, true}) {
            const auto finest = noise_grid<T>(rows, cols, 5);
            set_thread_count(1);
            set_simd_enabled(true);
            const auto pyramid = analysed(finest, spec_of(-1, exact));
            const auto back = coefficients(pyramid, 0, 0);
            auto gradient = empty_pyramid<T>(spec_of(-1, exact), rows, cols);
            adjoint<T>(finest.view(), 0, gradient);
            for (const auto& [threads, simd] : {std::pair{4, true}, {1, false}, {3, false}}) {
                set_thread_count(threads);
                set_simd_enabled(simd);
                EXPECT_TRUE(same_bytes(pyramid, analysed(finest, spec_of(-1, exact))));
                EXPECT_TRUE(same_bytes(back, coefficients(pyramid, 0, 0)));
                auto again = empty_pyramid<T>(spec_of(-1, exact), rows, cols);
                adjoint<T>(finest.view(), 0, again);
                EXPECT_TRUE(same_bytes(gradient, again));
            }
        }
}

/// <A x, y> = <x, A' y>, all sizes up to 12 x 12 and some more. Sums of some thousand products of
/// numbers below 10.
TEST(Cubic, AdjointIsTheTranspose) {
    const auto check = [](std::int64_t rows, std::int64_t cols, const SchemeSpec& spec) {
        auto pyramid = empty_pyramid<double>(spec, rows, cols);
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
            const LatticeBox& box = pyramid.layout.bands[k].box;
            pyramid.bands[k][0] = noise_grid<double>(box.rows, box.cols, 7 * k + 1);
        }
        const auto samples = coefficients(pyramid, 0, 0);
        const auto residual = noise_grid<double>(rows, cols, 99);
        auto gradient = empty_pyramid<double>(spec, rows, cols);
        adjoint<double>(residual.view(), 0, gradient);
        double right = 0;
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
            right += test::dot<double>(pyramid.bands[k][0].view(), gradient.bands[k][0].view());
        EXPECT_NEAR(test::dot<double>(samples.view(), residual.view()), right, 1e-11)
            << rows << " x " << cols;
    };
    for (const bool exact : {false, true}) {
        for (std::int64_t rows = 1; rows <= 12; ++rows)
            for (std::int64_t cols = 1; cols <= 12; ++cols)
                check(rows, cols, spec_of(std::max(rows, cols) > 4 ? 3 : 0, exact));
        check(77, 50, spec_of(-1, exact));
        check(64, 129, spec_of(5, exact));
    }
}

/// Constants have no detail; in the middle, polynomials up to degree 1 have none either, whatever
/// the mirror does to them at the borders. Rounding of values up to 100.
TEST(Cubic, PlanesHaveNoDetailAwayFromBorders) {
    for (const bool exact : {false, true}) {
        const auto constant = Grid<double>(37, 50, 42.0);
        const auto pyramid = analysed(constant, spec_of(3, exact));
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
            const LatticeBox& box = pyramid.layout.bands[k].box;
            const Grid<double> expected(box.rows, box.cols, k == 0 ? 42.0 : 0.0);
            EXPECT_LT(largest_difference(expected, pyramid.bands[k][0]), 1e-12) << k;
        }
    }
    Grid<double> plane(100, 120);
    for (std::int64_t r = 0; r < 100; ++r)
        for (std::int64_t c = 0; c < 120; ++c)
            plane(r, c) = 3 + 0.5 * static_cast<double>(r) - 0.25 * static_cast<double>(c);
    const auto pyramid = analysed(plane, spec_of(1));
    for (std::size_t k = 0; k < 4; ++k)
        for (std::int64_t r = 12; r < 38; ++r)
            for (std::int64_t c = 12; c < 48; ++c)
                EXPECT_NEAR(pyramid.bands[k][0](r, c), k == 0 ? plane(2 * r, 2 * c) : 0.0, 1e-12);
}

/// The spline itself is exact for cubics: in exact mode their details vanish in the middle, up to
/// what the recursion (0.268 a step) keeps of the borders after 50 steps.
TEST(Cubic, ExactModeReproducesCubics) {
    Grid<double> cubic(200, 200);
    const auto value = [](std::int64_t k) {
        const double x = (static_cast<double>(k) - 100) / 100;
        return 1 + x - 2 * x * x + 3 * x * x * x;
    };
    for (std::int64_t r = 0; r < 200; ++r)
        for (std::int64_t c = 0; c < 200; ++c) cubic(r, c) = value(r) * value(c);
    const auto pyramid = analysed(cubic, spec_of(1, true));
    for (std::size_t k = 1; k < 4; ++k)
        for (std::int64_t r = 40; r < 60; ++r)
            for (std::int64_t c = 40; c < 60; ++c)
                EXPECT_NEAR(pyramid.bands[k][0](r, c), 0, 1e-12) << k;
}

/// Root of the sums of squares of the difference over all bands and of the bands.
double relative_difference(const Pyramid<double>& a, const Pyramid<double>& b) {
    double difference = 0;
    double norm = 0;
    for (std::size_t k = 0; k < a.bands.size(); ++k)
        for (std::int64_t r = 0; r < a.bands[k][0].rows(); ++r)
            for (std::int64_t c = 0; c < a.bands[k][0].cols(); ++c) {
                const double d = a.bands[k][0](r, c) - b.bands[k][0](r, c);
                difference += d * d;
                norm += b.bands[k][0](r, c) * b.bands[k][0](r, c);
            }
    return std::sqrt(difference / norm);
}

/// The taps are those of the spline times 1.00028, and the first one cut off is 1.8e-4: a predicted
/// sample of white noise changes by sqrt(2 (0.61 2.8e-4)^2 + 2 (1.8e-4)^2) = 3.5e-4 of 1.17, the
/// update by half of that again, two axes add their squares.
TEST(Cubic, ExactModeIsCloseToTheCutTaps) {
    const auto line = noise_grid<double>(1, 5000, 3);
    EXPECT_LT(relative_difference(analysed(line, spec_of(1)), analysed(line, spec_of(1, true))),
              3.5e-4);
    const auto raster = noise_grid<double>(90, 101, 3);
    const double difference =
        relative_difference(analysed(raster, spec_of(3)), analysed(raster, spec_of(3, true)));
    EXPECT_LT(difference, 6e-4);
    EXPECT_GT(difference, 1e-4) << "the modes differ";
}

/// Norms are constants; here they are measured on one impulse in the middle of 512 x 512. At level
/// 5 they are doubled, which misses 3e-5, and the mirror adds to the tails of the atom.
TEST(Cubic, NormsAreThoseOfTheAtoms) {
    auto pyramid = empty_pyramid<double>(spec_of(5), 512, 512);
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
        const BandLayout& band = pyramid.layout.bands[k];
        double& middle = pyramid.bands[k][0](band.box.rows / 2, band.box.cols / 2);
        middle = 1;
        const auto atom = coefficients(pyramid, 0, 0);
        middle = 0;
        const double norm = std::sqrt(test::dot<double>(atom.view(), atom.view()));
        const double tolerance = band.level <= 4 ? 1e-6 : 4e-4;
        EXPECT_NEAR(norm / band.norm_samples, 1, tolerance) << band.name << ' ' << band.level;
        double most = 0;
        for (std::int64_t r = 0; r < 512; ++r)
            for (std::int64_t c = 0; c < 512; ++c) most = std::max(most, std::abs(atom(r, c)));
        EXPECT_NEAR(most / band.norm_max, 1, 1e-6) << band.name << ' ' << band.level;
    }
}

/// The specification gives four decimals.
TEST(Cubic, NormsMatchTheSpecification) {
    const auto bands = layout(spec_of(5), 512, 512, 1)->bands;
    const double expected[4][2] = {
        {1.0288, 0.6025}, {1.8307, 0.9577}, {3.6479, 1.9010}, {7.2968, 3.8025}};
    for (const BandLayout& band : bands) {
        if (band.channel == 0) continue;
        const int measured = std::min(band.level, 4);
        EXPECT_NEAR(std::ldexp(expected[measured - 1][band.channel == 3], band.level - measured),
                    band.norm_samples, 5e-5 * std::ldexp(1.0, band.level - measured));
    }
    EXPECT_NEAR(bands[0].norm_samples, 0.875 * 32, 5e-4 * 32) << "lowest lattice: 0.875 * 2^L";
}

/// Without details the values of a coarse level are interpolated: they stay where they are, for the
/// update receives nothing.
TEST(Cubic, CoarseValuesAreValuesOfTheFineSurface) {
    auto pyramid = empty_pyramid<double>(spec_of(3), 60, 75);
    pyramid.bands[0][0] = noise_grid<double>(8, 10, 4);
    const auto finest = coefficients(pyramid, 0, 0);
    for (std::int64_t r = 0; r < 8; ++r)
        for (std::int64_t c = 0; c < 10; ++c)
            EXPECT_EQ(finest(8 * r, 8 * c), pyramid.bands[0][0](r, c));
}

}  // namespace
}  // namespace relief::multires::cubic
