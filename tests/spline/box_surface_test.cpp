#include "relief/spline/box_surface.h"

#include <array>
#include <limits>

#include "relief/core/parallel.h"
#include "relief/core/simd.h"
#include "relief/spline/lattice_filters.h"
#include "spline/spline_testing.h"

namespace relief::spline {
namespace {

template <class T>
class BoxSurfaces : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(BoxSurfaces, Scalars);

template <class T>
BoxSurface<T> make(const Grid<T>& c, int order) {
    return std::move(BoxSurface<T>::create(c.view(), order)).value();
}

/// Value .. djj of many points, one vector a quantity.
template <class T>
using Jets = std::array<std::vector<T>, 6>;

template <class T>
Jets<T> evaluate(const BoxSurface<T>& surface, const std::vector<T>& i, const std::vector<T>& j,
                 int derivatives) {
    Jets<T> jets;
    for (auto& quantity : jets) quantity.assign(i.size(), T(77));
    const Status status =
        surface.evaluate(i, j, derivatives, {jets[0], jets[1], jets[2], jets[3], jets[4], jets[5]});
    EXPECT_TRUE(status.ok());
    return jets;
}

template <class T>
std::vector<T> random_points(std::size_t count, T low, T high, unsigned seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<T> draw(low, high);
    std::vector<T> points(count);
    for (T& x : points) x = draw(engine);
    return points;
}

TEST(BoxSurface, GoldenJets) {
    const nlohmann::json data = golden()["evaluation"];
    const auto period_rows = static_cast<double>(data["coefficients"].size());
    const auto period_cols = static_cast<double>(data["coefficients"][0].size());
    const Grid<double> coefficients = tiled(data["coefficients"], 5);
    const double tolerances[] = {1e-12, 1e-12, 1e-12, 1e-10, 1e-10, 1e-10};
    for (const int d : {1, 2, 3}) {
        const BoxSurface<double> surface = make(coefficients, d);
        for (std::size_t k = 0; k < data["points"].size(); ++k) {
            const double i = data["points"][k][0].get<double>() + 2 * period_rows;
            const double j = data["points"][k][1].get<double>() + 2 * period_cols;
            const SurfaceJet<double> jet = surface.jet(i, j);
            const double quantities[] = {jet.value, jet.di, jet.dj, jet.dii, jet.dij, jet.djj};
            const auto expected =
                data[std::string("d").append(std::to_string(d))][k].get<std::vector<double>>();
            for (std::size_t q = 0; q < expected.size(); ++q)
                EXPECT_NEAR(quantities[q], expected[q], tolerances[q])
                    << "order " << d << ", quantity " << q;
        }
    }
}

TEST(BoxSurface, IsTheSumOfItsBasisFunctions) {
    for (int d = 1; d <= kMaxOrder; ++d) {
        Grid<double> c(15, 16, 0.0);
        c(7, 8) = 1;
        const BoxSurface<double> surface = make(c, d);
        for (double i = 0.03; i < 14; i += 0.31) {
            for (double j = 0.01; j < 15; j += 0.43) {
                const SurfaceJet<double> a = surface.jet(i, j);
                const SurfaceJet<double> b = box_spline_jet(d, i - 7, j - 8);
                EXPECT_NEAR(a.value, b.value, 1e-14);
                EXPECT_NEAR(a.di, b.di, 1e-13);
                EXPECT_NEAR(a.dj, b.dj, 1e-13);
                EXPECT_NEAR(a.dii, b.dii, 1e-12);
                EXPECT_NEAR(a.dij, b.dij, 1e-12);
                EXPECT_NEAR(a.djj, b.djj, 1e-12);
            }
        }
    }
}

TYPED_TEST(BoxSurfaces, PlanesAreReproducedUpToTheBorder) {
    using T = TypeParam;
    const double eps = std::numeric_limits<T>::epsilon();
    for (int d = 1; d <= kMaxOrder; ++d) {
        for (const auto& [rows, cols] :
             {std::pair{1, 1}, {1, 6}, {5, 1}, {2, 2}, {3, 9}, {8, 7}, {4, 4}}) {
            // The border rule continues planes over as many rows as there are, less one, and
            // constants.
            if ((rows > 1 && rows < d) || (cols > 1 && cols < d)) continue;
            const auto plane = [](double i, double j) { return 1 + i / 8 - j / 4; };
            const BoxSurface<T> surface = make(sampled<T>(rows, cols, plane), d);
            for (double i = 0; i <= rows - 1; i += 0.125) {
                for (double j = 0; j <= cols - 1; j += 0.125) {
                    const SurfaceJet<T> jet = surface.jet(i, j);
                    EXPECT_NEAR(jet.value, plane(i, j), 16 * eps);
                    EXPECT_NEAR(jet.di, rows > 1 ? 0.125 : 0, 100 * eps);
                    EXPECT_NEAR(jet.dj, cols > 1 ? -0.25 : 0, 100 * eps);
                    EXPECT_NEAR(jet.dii, 0, 1000 * eps);
                    EXPECT_NEAR(jet.dij, 0, 1000 * eps);
                    EXPECT_NEAR(jet.djj, 0, 1000 * eps);
                }
            }
        }
    }
}

TYPED_TEST(BoxSurfaces, BatchesAreJetsToTheBit) {
    using T = TypeParam;
    for (int d = 1; d <= kMaxOrder; ++d) {
        const BoxSurface<T> surface = make(noise<T>(23, 31, 7), d);
        std::vector<T> i = random_points<T>(5000, -2, 25, 1);
        std::vector<T> j = random_points<T>(5000, -2, 33, 2);
        for (std::size_t k = 0; k < 200; ++k)
            j[k] = i[k] = std::floor(i[k]);  // vertices and diagonals
        i[300] = std::numeric_limits<T>::quiet_NaN();
        j[301] = std::numeric_limits<T>::infinity();
        const Jets<T> jets = evaluate(surface, i, j, 2);
        for (std::size_t k = 0; k < i.size(); ++k) {
            const SurfaceJet<T> jet = surface.jet(i[k], j[k]);
            const T expected[] = {jet.value, jet.di, jet.dj, jet.dii, jet.dij, jet.djj};
            for (std::size_t q = 0; q < 6; ++q)
                EXPECT_EQ(0, std::memcmp(&jets[q][k], &expected[q], sizeof(T)))
                    << "order " << d << " point " << k;
        }
    }
}

TYPED_TEST(BoxSurfaces, BytesDoNotDependOnThreadsOrInstructions) {
    using T = TypeParam;
    for (int d = 1; d <= kMaxOrder; ++d) {
        const BoxSurface<T> surface = make(noise<T>(40, 57, 8), d);
        const std::vector<T> i = random_points<T>(20011, 0, 39, 3);
        const std::vector<T> j = random_points<T>(20011, 0, 56, 4);
        set_thread_count(1);
        const Jets<T> expected = evaluate(surface, i, j, 2);
        set_thread_count(2);
        EXPECT_EQ(evaluate(surface, i, j, 2), expected);
        set_simd_enabled(false);
        EXPECT_EQ(evaluate(surface, i, j, 2), expected);
        set_simd_enabled(true);
        set_thread_count(0);
    }
}

TYPED_TEST(BoxSurfaces, OnlyTheDerivativesAskedForAreWritten) {
    using T = TypeParam;
    const BoxSurface<T> surface = make(noise<T>(9, 9, 9), 2);
    const std::vector<T> points = random_points<T>(100, 0, 8, 5);
    const Jets<T> all = evaluate(surface, points, points, 2);
    for (int derivatives = 0; derivatives < 2; ++derivatives) {
        const Jets<T> some = evaluate(surface, points, points, derivatives);
        for (std::size_t q = 0; q < 6; ++q) {
            const bool written = q == 0 || (derivatives == 1 && q < 3);
            EXPECT_EQ(some[q], written ? all[q] : std::vector<T>(100, T(77))) << q;
        }
    }
}

TYPED_TEST(BoxSurfaces, GridsAreJetsUpToRounding) {
    using T = TypeParam;
    // Rounding of the values, and of positions below 64 that are no binary fractions, times a slope
    // below 4.
    const double tolerance = 8 * std::numeric_limits<T>::epsilon() + 64 * 4 * 2.3e-16;
    for (int d = 1; d <= kMaxOrder; ++d) {
        const BoxSurface<T> surface = make(noise<T>(37, 45, 10), d);
        const auto expect_jets = [&](double di, double dj) {
            const double i0 = di < 0 ? 38 : -1.25;
            const double j0 = dj < 0 ? 46 : -2.5;
            Grid<T> out(50, 300, T(77));
            surface.evaluate_grid(i0, di, j0, dj, out.view());
            const Grid<T> jets = sampled<T>(50, 300, [&](double r, double c) {
                return surface.jet(i0 + r * di, j0 + c * dj).value;
            });
            EXPECT_LE(largest_difference(out, jets), tolerance)
                << d << " steps " << di << ", " << dj;
        };
        for (const double di : {-0.5, 0.25, 0.37, 1.0})
            for (const double dj : {0.0, -1.0, 0.125, 0.2, 0.25, 0.37, 0.75, 1.0, 2.0, 9.0})
                expect_jets(di, dj);
    }
}

TYPED_TEST(BoxSurfaces, GridBytesDoNotDependOnThreadsOrInstructions) {
    using T = TypeParam;
    for (const double step : {0.25, 0.3}) {
        const BoxSurface<T> surface = make(noise<T>(80, 90, 11), 2);
        const auto values = [&] {
            Grid<T> out(300, 310);
            surface.evaluate_grid(0, step, 0, step, out.view());
            return out;
        };
        set_thread_count(1);
        const Grid<T> expected = values();
        set_thread_count(2);
        EXPECT_TRUE(same_bytes(values(), expected));
        set_simd_enabled(false);
        EXPECT_TRUE(same_bytes(values(), expected));
        set_simd_enabled(true);
        set_thread_count(0);
    }
}

TEST(BoxSurface, PointsOutsideAreMovedToTheBorder) {
    const BoxSurface<double> surface = make(noise<double>(6, 7, 12), 2);
    EXPECT_EQ(surface.jet(-3, 2.5).value, surface.jet(0, 2.5).value);
    EXPECT_EQ(surface.jet(1e300, 9).value, surface.jet(5, 6).value);
    EXPECT_EQ(surface.jet(std::nan(""), 1.5).value, surface.jet(0, 1.5).value);
    EXPECT_TRUE(surface.contains(5, 6));
    EXPECT_TRUE(surface.contains(0, 0));
    EXPECT_FALSE(surface.contains(5.0001, 6));
    EXPECT_FALSE(surface.contains(std::nan(""), 0));
}

TEST(BoxSurface, ExchangingTheAxesTransposesTheSurface) {
    EXPECT_TRUE(rc::check([] {
        const int d = *rc::gen::inRange(2, kMaxOrder + 1);
        const auto rows = *rc::gen::inRange<std::int64_t>(1, 12);
        const auto cols = *rc::gen::inRange<std::int64_t>(1, 12);
        const Grid<double> c = noise<double>(rows, cols, *rc::gen::arbitrary<unsigned>());
        const Grid<double> transposed = sampled<double>(cols, rows, [&](double i, double j) {
            return c(static_cast<std::int64_t>(j), static_cast<std::int64_t>(i));
        });
        const double i = *rc::gen::inRange(0, 1001) / 1000.0 * static_cast<double>(rows - 1);
        const double j = *rc::gen::inRange(0, 1001) / 1000.0 * static_cast<double>(cols - 1);
        const SurfaceJet<double> a = make(c, d).jet(i, j);
        const SurfaceJet<double> b = make(transposed, d).jet(j, i);
        // The corner of the ring sums the same terms in another order.
        RC_ASSERT(std::abs(a.value - b.value) < 1e-13);
        RC_ASSERT(std::abs(a.di - b.dj) < 1e-12);
        RC_ASSERT(std::abs(a.dij - b.dij) < 1e-11);
        RC_ASSERT(std::abs(a.djj - b.dii) < 1e-11);
    }));
}

/// The example of docs/evaluation.md.
Status enlarge(const Grid<double>& samples, SurfaceJet<double>& found, Grid<double>& result) {
    Grid<double> coefficients(samples.rows(), samples.cols());
    RELIEF_CHECK(interpolate_lattice<double>(2, samples.view(), coefficients.view()));
    RELIEF_TRY(const auto surface, BoxSurface<double>::create(coefficients.view(), 2));
    const SurfaceJet<double> jet = surface.jet(10.25, 7.5);  // value, di, dj, dii, dij, djj
    Grid<double> enlarged(4 * samples.rows() - 3, 4 * samples.cols() - 3);
    surface.evaluate_grid(0, 0.25, 0, 0.25, enlarged.view());
    found = jet;
    result = std::move(enlarged);
    return {};
}

TEST(BoxSurface, EnlargementPassesThroughTheSamples) {
    const Grid<double> samples = noise<double>(20, 15, 13);
    SurfaceJet<double> jet;
    Grid<double> enlarged;
    ASSERT_TRUE(enlarge(samples, jet, enlarged).ok());
    for (std::int64_t r = 0; r < samples.rows(); ++r)
        for (std::int64_t c = 0; c < samples.cols(); ++c)
            EXPECT_NEAR(enlarged(4 * r, 4 * c), samples(r, c), 1e-14);
    EXPECT_NEAR(enlarged(41, 30), jet.value, 1e-14);
}

TEST(BoxSurface, WrongCallsAreRefused) {
    const Grid<double> c(3, 3, 1.0);
    EXPECT_EQ(BoxSurface<double>::create(c.view(), 5).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(BoxSurface<double>::create(Grid<double>().view(), 2).error().code,
              ErrorCode::BadInput);
    const BoxSurface<double> surface = make(c, 2);
    std::vector<double> two(2), three(3);
    EXPECT_EQ(surface.evaluate(two, two, 3, {two}).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(surface.evaluate(two, three, 0, {two}).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(surface.evaluate(two, two, 1, {two}).error().code, ErrorCode::InvalidArgument);
    EXPECT_TRUE(surface.evaluate(two, two, 0, {two}).ok());
}

}  // namespace
}  // namespace relief::spline
