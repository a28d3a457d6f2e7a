#include "multires/box_reference.h"

#include <Eigen/Dense>
#include <utility>

#include "multires/box_factors.h"
#include "multires/box_level.h"
#include "relief/core/parallel.h"
#include "relief/core/simd.h"

namespace relief::multires::box {
namespace {

using Size = std::pair<std::int64_t, std::int64_t>;
const std::vector<Size> kSizes = {{1, 1},   {1, 2},    {2, 1},   {1, 7},  {7, 1},   {1, 100},
                                  {33, 1},  {2, 2},    {2, 5},   {5, 2},  {3, 3},   {2, 40},
                                  {4, 4},   {8, 8},    {9, 13},  {17, 4}, {16, 31}, {20, 21},
                                  {22, 23}, {100, 37}, {41, 300}};

template <class T>
class Box : public testing::Test {
  public:
    /// Rounding errors grow with the condition of the transform, at most about 20 in the amplitude,
    /// and with its depth.
    static constexpr double kTolerance = std::is_same_v<T, float> ? 1e-5 : 2e-14;
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Box, Scalars);

TYPED_TEST(Box, ReconstructsEverySize) {
    for (const int order : {1, 2}) {
        for (const auto& [rows, cols] : kSizes) {
            const auto input = noise<TypeParam>(rows, cols, unsigned(rows * 1000 + cols));
            const auto pyramid = analysed(order, input);
            EXPECT_LE(largest_difference(coefficients(pyramid, 0, 0), input), this->kTolerance)
                << "order " << order << ", " << rows << " x " << cols;
        }
    }
}

TEST(BoxProperties, ReconstructsRandomSizesAndDepths) {
    EXPECT_TRUE(rc::check([] {
        const auto rows = *rc::gen::inRange<std::int64_t>(1, 70);
        const auto cols = *rc::gen::inRange<std::int64_t>(1, 70);
        const auto order = *rc::gen::element(1, 2);
        const int most = layout({.order = order}, rows, cols, 1).value().levels();
        const auto levels = *rc::gen::inRange(0, most + 1);
        const auto input = noise<double>(rows, cols, unsigned(rows + 100 * cols));
        RC_ASSERT(largest_difference(coefficients(analysed(order, input, levels), 0, 0), input) <
                  2e-14);
    }));
}

TEST(BoxProperties, CoarseLevelsAreThoseOfAnalysis) {
    const auto input = noise<double>(45, 60, 3);
    const auto deep = analysed(2, input);
    for (int level = 0; level <= deep.layout.levels(); ++level) {
        const auto shallow = analysed(2, input, level);
        EXPECT_LE(largest_difference(coefficients(deep, 0, level), shallow.bands[0][0]), 2e-14)
            << level;
    }
}

TEST(BoxProperties, DetailsOfPlanesVanish) {
    for (const int order : {1, 2}) {
        for (const auto& [rows, cols] : kSizes) {
            const auto plane =
                grid_from<double>(rows, cols, [](auto i, auto j) { return 3 + 2.0 * i - 0.5 * j; });
            const auto pyramid = analysed(order, plane);
            for (std::size_t k = 1; k < pyramid.bands.size(); ++k)
                EXPECT_LE(largest(pyramid.bands[k][0]), 1e-14 * largest(plane))
                    << order << " " << rows << " x " << cols << " band " << k;
        }
    }
}

/// Box-spline coefficients that are a cubic polynomial: away from the border the quartic wavelets
/// do not see it.
TEST(BoxProperties, QuarticDetailsOfCubicsVanishInside) {
    const auto cubic = grid_from<double>(129, 129, [](auto row, auto col) {
        const double x = (double(row) - 64) / 64;
        const double y = (double(col) - 64) / 64;
        return 1 + x - y + x * y - 2 * y * y + x * x * x - 3 * x * x * y + x * y * y +
               0.5 * y * y * y;
    });
    auto pyramid = analysed(2, cubic, 2);
    for (const int level : {1, 2}) {
        for (const int channel : {1, 2, 3}) {
            const auto& band = edge_band(pyramid, level, channel);
            const std::int64_t rim = level == 1 ? 2 : 4;
            for (std::int64_t i = rim; i < band.rows() - rim; ++i)
                for (std::int64_t j = rim; j < band.cols() - rim; ++j)
                    EXPECT_NEAR(band(i, j), 0, 3e-14);
        }
    }
}

/// One coarse coefficient refined: hat function of order 1, Loop's mask of order 2.
TEST(BoxProperties, CoarseSurfacesObeyTheTwoScaleRelation) {
    for (const int order : {1, 2}) {
        auto pyramid = empty_pyramid<double>(order, 17, 17, 1);
        pyramid.bands[0][0](4, 4) = 1;
        const auto fine = coefficients(pyramid, 0, 0);
        for (std::int64_t i = -8; i <= 8; ++i) {
            for (std::int64_t j = -8; j <= 8; ++j) {
                const auto distance = std::max({std::abs(i), std::abs(j), std::abs(i - j)});
                const bool along_edge = i == 0 || j == 0 || i == j;
                double expected = 0;
                if (order == 1) expected = distance == 0 ? 1 : distance == 1 ? 0.5 : 0;
                if (order == 2 && distance <= 1) expected = distance == 0 ? 5.0 / 8 : 3.0 / 8;
                if (order == 2 && distance == 2) expected = along_edge ? 1.0 / 16 : 1.0 / 8;
                EXPECT_NEAR(fine(8 + i, 8 + j), expected, 1e-15) << order << ": " << i << ", " << j;
            }
        }
    }
}

TEST(BoxProperties, CurvesAreCubicSplinesAtEitherOrientation) {
    const auto line = noise<double>(1, 40, 9);
    const auto column = grid_from<double>(40, 1, [&](auto i, auto) { return line(0, i); });
    auto along = analysed(2, line);
    auto down = analysed(2, column);
    for (int level = 1; level <= along.layout.levels(); ++level) {
        const auto& e2 = edge_band(along, level, 2);
        const auto& e1 = edge_band(down, level, 1);
        for (std::int64_t j = 0; j < e2.cols(); ++j) EXPECT_EQ(e2(0, j), e1(j, 0));
    }
    auto bump = empty_pyramid<double>(2, 1, 17, 1);
    bump.bands[0][0](0, 4) = 1;
    const auto fine = coefficients(bump, 0, 0);
    const double mask[] = {0, 1.0 / 8, 1.0 / 2, 3.0 / 4, 1.0 / 2, 1.0 / 8, 0};
    for (int k = 0; k < 7; ++k) EXPECT_NEAR(fine(0, 5 + k), mask[k], 1e-16);
}

template <class T>
double dot(const Grid<T>& a, const Grid<T>& b) {
    double sum = 0;
    for (std::int64_t i = 0; i < a.rows(); ++i)
        for (std::int64_t j = 0; j < a.cols(); ++j) sum += double(a(i, j)) * double(b(i, j));
    return sum;
}

TYPED_TEST(Box, AdjointIsTheTranspose) {
    using T = TypeParam;
    for (const int order : {1, 2}) {
        for (const auto& [rows, cols] : kSizes) {
            auto z = empty_pyramid<T>(order, rows, cols);
            for (std::size_t k = 0; k < z.bands.size(); ++k)
                z.bands[k][0] = noise<T>(z.bands[k][0].rows(), z.bands[k][0].cols(), unsigned(k));
            const auto r = noise<T>(rows, cols, 77);
            auto transposed = empty_pyramid<T>(order, rows, cols);
            adjoint<T>(r.view(), 0, transposed);
            double right = 0;
            for (std::size_t k = 0; k < z.bands.size(); ++k)
                right += dot(z.bands[k][0], transposed.bands[k][0]);
            EXPECT_NEAR(dot(coefficients(z, 0, 0), r), right,
                        20 * this->kTolerance * std::sqrt(double(rows * cols)))
                << "order " << order << ", " << rows << " x " << cols;
        }
    }
}

TYPED_TEST(Box, AnyThreadCountAndScalarCodeGiveTheSameBytes) {
    using T = TypeParam;
    for (const int order : {1, 2}) {
        for (const auto& [rows, cols] : std::vector<Size>{{300, 90}, {611, 1030}, {31, 2100}}) {
            const auto input = noise<T>(rows, cols, 5);
            const auto run = [&](int threads, bool simd) {
                set_thread_count(threads);
                set_simd_enabled(simd);
                auto pyramid = analysed(order, input);
                auto back = coefficients(pyramid, 0, 0);
                auto transposed = empty_pyramid<T>(order, rows, cols);
                adjoint<T>(input.view(), 0, transposed);
                set_thread_count(0);
                set_simd_enabled(true);
                return std::make_tuple(std::move(pyramid), std::move(back), std::move(transposed));
            };
            const auto one = run(1, true);
            for (const auto& [threads, simd] :
                 std::vector<std::pair<int, bool>>{{2, true}, {1, false}, {2, false}}) {
                const auto other = run(threads, simd);
                EXPECT_TRUE(same_bytes(std::get<0>(one), std::get<0>(other)))
                    << order << " " << rows;
                EXPECT_TRUE(same_bytes(std::get<1>(one), std::get<1>(other)))
                    << order << " " << rows;
                EXPECT_TRUE(same_bytes(std::get<2>(one), std::get<2>(other)))
                    << order << " " << rows;
            }
        }
    }
}

/// Collapsed tables against the integrals of every function of the whole raster.
TEST(BoxReference, FactorsOfCollapsedTablesAreThoseOfTheWholeRaster) {
    for (const int order : {1, 2}) {
        for (auto [rows, cols] :
             std::vector<Size>{{2, 2}, {5, 40}, {21, 20}, {64, 47}, {100, 129}, {98, 255}}) {
            Grid<double> integrals(rows, cols, 1.0);
            const int levels = layout({.order = order}, rows, cols, 1).value().levels();
            const auto tables = update_factors(order, rows, cols, levels);
            for (int level = 1; level <= levels; ++level) {
                const ReferenceLevel<double> reference(order, rows, cols, integrals);
                rows = coarser(rows);
                cols = coarser(cols);
                for (int k = 0; k < kEdgeKinds; ++k) {
                    const auto expected = reference.factors()[std::size_t(k)].view();
                    for (std::int64_t i = 0; i < expected.rows; ++i)
                        for (std::int64_t j = 0; j < expected.cols; ++j)
                            EXPECT_NEAR(tables[std::size_t(level - 1)].at(k, i, j), expected(i, j),
                                        1e-12)
                                << "level " << level << " kind " << k << " at " << i << ", " << j;
                }
            }
        }
    }
}

TYPED_TEST(Box, RowPipelineIsThePointwiseReferenceToTheBit) {
    using T = TypeParam;
    for (const int order : {1, 2}) {
        for (const auto& [rows, cols] :
             std::vector<Size>{{2, 2}, {3, 3}, {4, 7}, {9, 13}, {40, 70}, {131, 1300}, {600, 50}}) {
            const auto input = noise<T>(rows, cols, 21);
            Grid<double> integrals(rows, cols, 1.0);
            ReferenceLevel<T> reference(order, rows, cols, integrals);
            const auto per_level = update_factors(order, rows, cols, 1);
            const UpdateFactors& factors = per_level[0];
            auto exact = std::array<Grid<double>, kEdgeKinds>();
            for (int k = 0; k < kEdgeKinds; ++k) {
                const auto& table = reference.factors()[std::size_t(k)];
                exact[std::size_t(k)] =
                    grid_from<double>(table.rows(), table.cols(),
                                      [&](auto i, auto j) { return factors.at(k, i, j); });
            }
            reference.set_factors(std::move(exact));
            reference.analyse(input);
            Grid<T> vertices(coarser(rows), coarser(cols));
            std::array<Grid<T>, kEdgeKinds> edges;
            EdgePlanes<T> views;
            for (std::size_t k = 0; k < edges.size(); ++k) {
                edges[k] = Grid<T>(reference.edges[k].rows(), reference.edges[k].cols());
                views[k] = edges[k].view();
            }
            analyse_level<T>(order, factors, input.view(), vertices.view(), views);
            EXPECT_TRUE(same_bytes(vertices, reference.vertices))
                << order << ": " << rows << " x " << cols;
            for (std::size_t k = 0; k < edges.size(); ++k)
                EXPECT_TRUE(same_bytes(edges[k], reference.edges[k]))
                    << order << ": " << rows << " x " << cols;
            const auto expected = reference.synthesise();
            for (const Traffic traffic : {Traffic::Cached, Traffic::Streamed}) {
                Grid<T> back(rows, cols);
                synthesise_level<T>(order, factors, vertices.view(), {views[0], views[1], views[2]},
                                    traffic, back.view());
                EXPECT_TRUE(same_bytes(back, expected)) << order << ": " << rows << " x " << cols;
            }
        }
    }
}

/// Condition of the synthesis matrix with unit columns: section 7.1 of the specification lists the
/// first two of each.
TEST(BoxProperties, ConditionOnBoxesIsThatOfTheSpecification) {
    const std::vector<std::tuple<int, std::int64_t, double>> table = {
        {1, 9, 5.6}, {1, 17, 9.1}, {2, 9, 60}, {2, 17, 133}};
    for (const auto& [order, side, condition] : table) {
        const std::int64_t n = side * side;
        Eigen::MatrixXd synthesis(n, n);
        Eigen::Index column = 0;
        auto z = empty_pyramid<double>(order, side, side, side == 9 ? 2 : 3);
        for (Planes<double>& band : z.bands) {
            for (std::int64_t k = 0; k < band[0].count(); ++k) {
                double& unit = band[0](k / band[0].cols(), k % band[0].cols());
                unit = 1;
                const auto atom = coefficients(z, 0, 0);
                unit = 0;
                for (std::int64_t p = 0; p < n; ++p)
                    synthesis(p, column) = atom(p / side, p % side);
                synthesis.col(column++).normalize();
            }
        }
        ASSERT_EQ(column, n);
        const Eigen::VectorXd eigenvalues =
            Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(synthesis.transpose() * synthesis,
                                                           Eigen::EigenvaluesOnly)
                .eigenvalues();
        const double measured = eigenvalues[n - 1] / eigenvalues[0];
        EXPECT_NEAR(measured / condition, 1, 0.05)
            << "order " << order << ", side " << side << ": " << measured << " (root "
            << std::sqrt(measured) << ")";
    }
}

TEST(BoxLayout, BandsAreCoarseToFine) {
    const auto made = layout({.order = 2, .levels = 2}, 100, 37, 3);
    ASSERT_TRUE(made.ok());
    const auto& bands = made.value().bands;
    ASSERT_EQ(bands.size(), 7U);
    EXPECT_EQ(bands[0].name, "scaling");
    EXPECT_EQ(bands[0].box, (LatticeBox{0, 0, 26, 10}));
    EXPECT_EQ(bands[1].name, "edge1");
    EXPECT_EQ(bands[1].level, 2);
    EXPECT_EQ(bands[1].box, (LatticeBox{0, 0, 25, 10}));
    EXPECT_EQ(bands[5].name, "edge2");
    EXPECT_EQ(bands[5].level, 1);
    EXPECT_EQ(bands[5].box, (LatticeBox{0, 0, 51, 18}));
    EXPECT_EQ(bands[6].box, (LatticeBox{0, 0, 50, 18}));
}

TEST(BoxLayout, HasAsManyCoefficientsAsPaddedSamples) {
    EXPECT_EQ(layout({}, 129, 129, 1).value().coefficients(), 129 * 129);
    EXPECT_EQ(layout({.levels = 6}, 129, 65, 1).value().coefficients(), 129 * 65);
    EXPECT_EQ(layout({}, 4096, 4096, 1).value().coefficients(), 4097 * 4097);
    EXPECT_EQ(layout({.levels = 1}, 100, 37, 1).value().coefficients(), 101 * 37);
    EXPECT_EQ(layout({}, 129, 129, 1).value().levels(), 7);
}

TEST(BoxLayout, RefusesWhatItCanNotDo) {
    const auto message = [](SchemeSpec spec, std::int64_t rows, std::int64_t cols, int components) {
        const auto made = layout(spec, rows, cols, components);
        return made.ok() ? std::string("accepted") : made.error().text();
    };
    EXPECT_EQ(message({.order = 3}, 9, 9, 1),
              "order: scheme box has orders 1 (linear) and 2 (quartic), not 3");
    EXPECT_EQ(message({.levels = 4}, 9, 9, 1),
              "levels: 4 levels; a raster of 9 x 9 has at most 3 (-1: all of them)");
    EXPECT_EQ(message({.levels = -2}, 9, 9, 1),
              "levels: -2 levels; a raster of 9 x 9 has at most 3 (-1: all of them)");
    EXPECT_EQ(message({}, 9, 9, 5), "components: 5 components; give 1 to 4");
    EXPECT_EQ(message({}, 0, 9, 1),
              "raster: a raster of 0 x 9 samples; each side must have 1 to 2147483647");
    EXPECT_EQ(message({}, 9, std::int64_t{1} << 31, 1),
              "raster: a raster of 9 x 2147483648 samples; each side must have 1 to 2147483647");
}

}  // namespace
}  // namespace relief::multires::box
