#include "relief/spline/cubic_surface.h"

#include <array>
#include <limits>

#include "relief/core/parallel.h"
#include "relief/core/simd.h"
#include "relief/spline/cubic_filters.h"
#include "spline/spline_testing.h"

namespace relief::spline {
namespace {

template <class T>
class CubicSurfaces : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(CubicSurfaces, Scalars);

template <class T>
CubicSurface<T> through(const Grid<T>& values) {
    return std::move(CubicSurface<T>::create(values.view())).value();
}

std::int64_t mirrored(std::int64_t k, std::int64_t n) {
    if (n == 1) return 0;
    while (k < 0 || k >= n) k = k < 0 ? -k : 2 * (n - 1) - k;
    return k;
}

constexpr std::pair<int, int> kSizes[] = {{1, 1}, {1, 2},   {2, 1},   {2, 2},  {3, 1},
                                          {1, 9}, {7, 200}, {131, 5}, {65, 67}};

/// (1 4 1)/6 along both axes of the mirrored coefficients gives the values back, to rounding of
/// coefficients that are up to 9 times as large.
TYPED_TEST(CubicSurfaces, CoefficientsGiveTheValues) {
    using T = TypeParam;
    const double tolerance = 20 * static_cast<double>(std::numeric_limits<T>::epsilon());
    for (const auto& [rows, cols] : kSizes) {
        const auto values = noise<T>(rows, cols, 4);
        Grid<T> c(rows, cols);
        ASSERT_TRUE(interpolate_cubic<T>(values.view(), c.view()).ok());
        const double weights[] = {1.0 / 6, 4.0 / 6, 1.0 / 6};
        for (std::int64_t i = 0; i < rows; ++i)
            for (std::int64_t j = 0; j < cols; ++j) {
                double sum = 0;
                for (int a = 0; a < 3; ++a)
                    for (int b = 0; b < 3; ++b)
                        sum += weights[a] * weights[b] *
                               static_cast<double>(
                                   c(mirrored(i + a - 1, rows), mirrored(j + b - 1, cols)));
                EXPECT_NEAR(sum, static_cast<double>(values(i, j)), tolerance);
            }
    }
}

TEST(CubicFilters, LinesMayEndHalfAStepBehind) {
    for (const std::int64_t n : {1, 2, 3, 40}) {
        const auto values = noise<double>(n, 3, 6);
        Grid<double> c = values.clone();
        solve_cubic_columns(c.view(), LineEnd::BehindLast);
        for (std::int64_t i = 0; i < n; ++i)
            for (std::int64_t j = 0; j < 3; ++j) {
                const double before = c(n == 1 ? 0 : std::abs(i - 1), j);
                const double after = c(std::min(i + 1, n - 1), j);
                EXPECT_NEAR((before + 4 * c(i, j) + after) / 6, values(i, j), 1e-14);
            }
    }
}

TYPED_TEST(CubicSurfaces, PassesThroughTheValues) {
    using T = TypeParam;
    const double tolerance = 30 * static_cast<double>(std::numeric_limits<T>::epsilon());
    for (const auto& [rows, cols] : kSizes) {
        const auto values = noise<T>(rows, cols, 5);
        const auto surface = through(values);
        EXPECT_EQ(surface.rows(), rows);
        EXPECT_EQ(surface.cols(), cols);
        for (std::int64_t i = 0; i < rows; ++i)
            for (std::int64_t j = 0; j < cols; ++j) {
                const auto jet = surface.jet(static_cast<double>(i), static_cast<double>(j));
                EXPECT_NEAR(static_cast<double>(jet.value), static_cast<double>(values(i, j)),
                            tolerance);
            }
    }
}

/// Bicubic polynomials and all their derivatives, where the mirror is 40 samples away: 0.268^40 =
/// 1e-23 of it is left, and rounding of values up to 4.
TEST(CubicSurface, ReproducesBicubicPolynomials) {
    const auto f = [](double x) { return 1 + x * (0.5 + x * (-1 + 2 * x)); };
    const auto f1 = [](double x) { return 0.5 + x * (-2 + 6 * x); };
    const auto f2 = [](double x) { return -2 + 12 * x; };
    const auto place = [](double k) { return k / 50 - 1; };
    const auto surface = through(sampled<double>(
        101, 101, [&](double i, double j) { return f(place(i)) * f(0.7 * place(j)); }));
    for (double i = 40; i < 60; i += 1.37)
        for (double j = 40; j < 60; j += 1.73) {
            const auto jet = surface.jet(i, j);
            const double x = place(i);
            const double y = 0.7 * place(j);
            EXPECT_NEAR(jet.value, f(x) * f(y), 1e-13);
            EXPECT_NEAR(jet.di, f1(x) * f(y) / 50, 1e-13);
            EXPECT_NEAR(jet.dj, f(x) * f1(y) * 0.7 / 50, 1e-13);
            EXPECT_NEAR(jet.dii, f2(x) * f(y) / 2500, 1e-13);
            EXPECT_NEAR(jet.dij, f1(x) * f1(y) * 0.7 / 2500, 1e-13);
            EXPECT_NEAR(jet.djj, f(x) * f2(y) * 0.49 / 2500, 1e-13);
        }
}

/// Value, gradient and Hessian agree on both sides of every lattice line; third derivatives of
/// noise are below 100, the step is 1e-9.
TEST(CubicSurface, IsC2AcrossCells) {
    const auto surface = through(noise<double>(20, 24, 7));
    const auto compare = [&](double i, double j, double step_i, double step_j) {
        const auto a = surface.jet(i - step_i, j - step_j);
        const auto b = surface.jet(i + step_i, j + step_j);
        EXPECT_NEAR(a.value, b.value, 1e-7);
        EXPECT_NEAR(a.di, b.di, 1e-7);
        EXPECT_NEAR(a.dj, b.dj, 1e-7);
        EXPECT_NEAR(a.dii, b.dii, 1e-6);
        EXPECT_NEAR(a.dij, b.dij, 1e-6);
        EXPECT_NEAR(a.djj, b.djj, 1e-6);
    };
    for (int k = 1; k < 19; ++k)
        for (double along = 0.3; along < 19; along += 2.3) {
            compare(k, along, 1e-9, 0);
            compare(along, k, 0, 1e-9);
        }
}

/// The mirror makes the slope across a border zero.
TEST(CubicSurface, BordersAreLevelAcross) {
    const auto surface = through(noise<double>(12, 15, 8));
    for (double t = 0; t <= 11; t += 0.7) {
        EXPECT_NEAR(surface.jet(t, 0).dj, 0, 1e-14);
        EXPECT_NEAR(surface.jet(t, 14).dj, 0, 1e-14);
        EXPECT_NEAR(surface.jet(0, t).di, 0, 1e-14);
        EXPECT_NEAR(surface.jet(11, t).di, 0, 1e-14);
    }
}

template <class T>
std::vector<T> points(std::size_t count, double last, unsigned seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> draw(-1, last + 1);
    std::vector<T> result(count);
    for (T& x : result) x = static_cast<T>(draw(engine));
    return result;
}

TYPED_TEST(CubicSurfaces, BatchesAreJetsToTheBitForAnyThreads) {
    using T = TypeParam;
    const auto surface = through(noise<T>(33, 47, 9));
    auto i = points<T>(9000, 32, 1);
    const auto j = points<T>(9000, 46, 2);
    i[5] = std::numeric_limits<T>::quiet_NaN();
    for (const int derivatives : {0, 1, 2}) {
        std::array<std::vector<T>, 6> out;
        for (auto& quantity : out) quantity.assign(i.size(), T(77));
        set_thread_count(derivatives == 1 ? 3 : 1);
        ASSERT_TRUE(
            surface.evaluate(i, j, derivatives, {out[0], out[1], out[2], out[3], out[4], out[5]})
                .ok());
        set_thread_count(0);
        for (std::size_t k = 0; k < i.size(); ++k) {
            const auto jet = surface.jet(static_cast<double>(i[k]), static_cast<double>(j[k]));
            const T expected[] = {jet.value, jet.di, jet.dj, jet.dii, jet.dij, jet.djj};
            const std::size_t written = derivatives == 0 ? 1 : derivatives == 1 ? 3 : 6;
            for (std::size_t q = 0; q < 6; ++q)
                ASSERT_EQ(out[q][k], q < written ? expected[q] : T(77)) << k << ' ' << q;
        }
    }
}

/// Enlarging, reducing, backwards, and past the border.
TYPED_TEST(CubicSurfaces, GridsAreJetsToTheBit) {
    using T = TypeParam;
    const auto surface = through(noise<T>(37, 45, 10));
    const double cases[][4] = {{0, 0.25, 0, 0.25},
                               {0.3, 1.7, 40, -0.9},
                               {-3, 0.77, -2, 1.01},
                               {36, -3.5, 5, 2.5},
                               {10, 0, 20, 0}};
    for (const auto& [i0, di, j0, dj] : cases) {
        Grid<T> out(53, 61);
        surface.evaluate_grid(i0, di, j0, dj, out.view());
        for (std::int64_t r = 0; r < out.rows(); ++r)
            for (std::int64_t c = 0; c < out.cols(); ++c)
                ASSERT_EQ(
                    out(r, c),
                    surface.jet(i0 + static_cast<double>(r) * di, j0 + static_cast<double>(c) * dj)
                        .value);
    }
    Grid<T> nothing(0, 0);
    surface.evaluate_grid(0, 1, 0, 1, nothing.view());
}

TYPED_TEST(CubicSurfaces, BytesDoNotDependOnThreadsOrInstructions) {
    using T = TypeParam;
    const auto values = noise<T>(150, 170, 11);
    const auto enlarged = [&](int threads, bool simd) {
        set_thread_count(threads);
        set_simd_enabled(simd);
        Grid<T> out(300, 340);
        through(values).evaluate_grid(0, 0.49, 0, 0.51, out.view());
        set_thread_count(0);
        set_simd_enabled(true);
        return out;
    };
    const auto expected = enlarged(1, true);
    EXPECT_TRUE(same_bytes(expected, enlarged(4, true)));
    EXPECT_TRUE(same_bytes(expected, enlarged(1, false)));
    EXPECT_TRUE(same_bytes(expected, enlarged(3, false)));
}

TEST(CubicSurface, PointsOutsideAreMovedToTheBorder) {
    const auto surface = through(noise<double>(6, 7, 12));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(surface.jet(-3, 2.5).value, surface.jet(0, 2.5).value);
    EXPECT_EQ(surface.jet(9, 100).value, surface.jet(5, 6).value);
    EXPECT_EQ(surface.jet(nan, 1).value, surface.jet(0, 1).value);
    EXPECT_TRUE(surface.contains(5, 6));
    EXPECT_FALSE(surface.contains(5.01, 6));
    EXPECT_FALSE(surface.contains(nan, 0));
}

TEST(CubicSurface, WrongCallsAreRefused) {
    EXPECT_EQ(CubicSurface<double>::create(Grid<double>().view()).error().code,
              ErrorCode::BadInput);
    const auto values = noise<double>(4, 4, 13);
    Grid<double> other(4, 5);
    EXPECT_EQ(interpolate_cubic<double>(values.view(), other.view()).error().code,
              ErrorCode::InvalidArgument);
    const auto surface = through(values);
    std::vector<double> at(3, 1.0);
    std::vector<double> out(3);
    EXPECT_EQ(surface.evaluate(at, at, 3, {out}).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(surface.evaluate(at, at, 1, {out}).error().code, ErrorCode::InvalidArgument);
    EXPECT_TRUE(surface.evaluate(at, at, 0, {out}).ok());
}

}  // namespace
}  // namespace relief::spline
