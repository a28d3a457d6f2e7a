#include "relief/multires/barycentric.h"

#include <cstring>
#include <tuple>

#include "hexagonal_reference.h"
#include "relief/core/parallel.h"
#include "relief/core/simd.h"
#include "support.h"

namespace relief::multires {
namespace {

using test::largest_difference;
using test::noise_grid;

SchemeSpec spec_of(int order, Family family, int dual, int levels) {
    return {SchemeId::Barycentric, order, family, dual, levels, DataMap::Coefficients};
}

SchemeSpec spec_named(const std::string& name, int levels) {
    if (name.substr(0, 2) == "cw") return spec_of(name[2] - '0', Family::SemiOrthogonal, 0, levels);
    return spec_of(name[3] - '0', Family::Compact, name[4] - '0', levels);
}

template <class T>
Pyramid<T> analysed(const Grid<T>& data, const SchemeSpec& spec) {
    auto layout = barycentric::layout(spec, data.rows(), data.cols(), 1);
    EXPECT_TRUE(layout.ok());
    auto pyramid = Pyramid<T>::allocate(*layout);
    barycentric::analyse<T>(data.view(), 0, pyramid);
    return pyramid;
}

const std::int64_t kSizes[][2] = {{1, 1},  {1, 7},  {7, 1},   {2, 5}, {8, 8},
                                  {9, 13}, {17, 4}, {16, 31}, {1, 2}, {3, 3}};

TEST(Barycentric, MatchesTheReferenceBoxes) {
    const auto examples = test::reference("barycentric.json")["box_frame"];
    for (const auto& example : examples) {
        const auto input = test::grid_of(example["input"]);
        const auto pyramid = analysed(input, spec_named(example["family"], 1));
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
            const BandLayout& band = pyramid.layout.bands[k];
            const auto& expected = example["analysis"][band.name];
            EXPECT_EQ(band.box.row0, expected["origin"][0].get<std::int64_t>()) << band.name;
            EXPECT_EQ(band.box.col0, expected["origin"][1].get<std::int64_t>()) << band.name;
            EXPECT_LT(largest_difference(test::grid_of(expected["values"]), pyramid.bands[k][0]),
                      1e-12)
                << band.name;
        }
    }
}

/// A torus is a box of three periods: the middle one sees no border (exact filters: up to the decay
/// of their poles).
TEST(Barycentric, MatchesTheReferenceTorus) {
    const auto examples = test::reference("barycentric.json")["torus_frame"];
    for (const auto& example : examples) {
        const auto period = test::grid_of(example["input"]);
        const std::int64_t n = period.rows();
        const std::int64_t copies = 15;
        Grid<double> tiled(copies * n, copies * n);
        for (std::int64_t r = 0; r < tiled.rows(); ++r)
            for (std::int64_t c = 0; c < tiled.cols(); ++c) tiled(r, c) = period(r % n, c % n);
        const auto pyramid = analysed(tiled, spec_named(example["family"], 1));
        const std::int64_t shift = copies / 2 * n / 2;
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
            const BandLayout& band = pyramid.layout.bands[k];
            const auto expected = test::grid_of(example["analysis"][band.name]);
            for (std::int64_t r = 0; r < n / 2; ++r)
                for (std::int64_t c = 0; c < n / 2; ++c)
                    EXPECT_NEAR(
                        expected(r, c),
                        pyramid.bands[k][0](shift + r - band.box.row0, shift + c - band.box.col0),
                        1e-12)
                        << example["family"] << ' ' << band.name << ' ' << r << ' ' << c;
        }
    }
}

TEST(Barycentric, TreeEqualsTheHexagonalConvolution) {
    const int pairs[][2] = {{1, 1}, {1, 3}, {1, 5}, {2, 2}, {2, 4}, {3, 1}, {3, 3}, {4, 2}, {4, 4}};
    for (const auto& pair : pairs)
        for (const auto& size : kSizes) {
            const auto data = noise_grid<double>(size[0], size[1], 5);
            const auto spec = spec_of(pair[0], Family::Compact, pair[1], 1);
            const FilterBank bank = *filter_bank(pair[0], Family::Compact, pair[1]);
            const auto pyramid = analysed(data, spec);
            const LatticeBox box{0, 0, size[0], size[1]};
            for (int c = 0; c < 8; ++c) {
                const auto k = static_cast<std::size_t>(c);
                const auto direct = test::direct_analysis(
                    analysis_kernel(bank, c), pyramid.layout.bands[k].box,
                    [&](auto i, auto j) { return test::extended(data, box, i, j); });
                // Sums of at most a few hundred products of size 1.
                EXPECT_LT(largest_difference(direct, pyramid.bands[k][0]), 1e-13);
            }
        }
}

TEST(Barycentric, SynthesisEqualsTheHexagonalConvolution) {
    for (const auto& [order, dual] : {std::pair{1, 1}, {2, 2}, {3, 3}, {4, 4}})
        for (const auto& size : kSizes) {
            const FilterBank bank = *filter_bank(order, Family::Compact, dual);
            auto layout =
                *barycentric::layout(spec_of(order, Family::Compact, dual, 1), size[0], size[1], 1);
            auto pyramid = Pyramid<double>::allocate(layout);
            const LatticeBox box{0, 0, size[0], size[1]};
            Grid<double> direct(size[0], size[1], 0.0);
            for (std::size_t k = 0; k < 8; ++k) {
                const LatticeBox& band = layout.bands[k].box;
                pyramid.bands[k][0] = noise_grid<double>(band.rows, band.cols, 20 + k);
                test::direct_synthesis(synthesis_kernel(bank, static_cast<int>(k)), band,
                                       pyramid.bands[k][0], box, direct);
            }
            EXPECT_LT(largest_difference(direct, barycentric::coefficients(pyramid, 0, 0)), 1e-13);
        }
}

template <class T>
void expect_reconstruction(const SchemeSpec& spec, std::int64_t rows, std::int64_t cols,
                           double tolerance) {
    const auto data = noise_grid<T>(rows, cols, static_cast<std::uint64_t>(rows * 100 + cols));
    const auto pyramid = analysed(data, spec);
    EXPECT_LE(largest_difference(data, barycentric::coefficients(pyramid, 0, 0)), tolerance)
        << rows << " x " << cols << " order " << spec.order << " dual " << spec.dual_order;
}

TEST(Barycentric, PerfectReconstruction) {
    const int pairs[][2] = {{1, 1}, {1, 3}, {1, 5}, {2, 2}, {2, 4}, {3, 1}, {3, 3}, {4, 2}, {4, 4}};
    for (const auto& size : kSizes) {
        for (const auto& pair : pairs) {
            // Rounding grows with filter length and levels; the reference implementation reaches
            // 1e-14.
            expect_reconstruction<double>(spec_of(pair[0], Family::Compact, pair[1], 2), size[0],
                                          size[1], 2e-13);
            expect_reconstruction<float>(spec_of(pair[0], Family::Compact, pair[1], 2), size[0],
                                         size[1], 1e-4);
        }
        for (int order = 1; order <= 4; ++order) {
            expect_reconstruction<double>(spec_of(order, Family::SemiOrthogonal, 0, 2), size[0],
                                          size[1], 2e-12);
            expect_reconstruction<float>(spec_of(order, Family::SemiOrthogonal, 0, 2), size[0],
                                         size[1], 1e-3);
        }
    }
    // All levels: the extension may triple values at each level's border, so rounding there grows
    // by 3 a level.
    expect_reconstruction<double>(spec_of(2, Family::Compact, 2, -1), 301, 700, 1e-10);
    expect_reconstruction<double>(spec_of(1, Family::Compact, 1, -1), 700, 301, 1e-12);
}

TEST(Barycentric, PerfectReconstructionOfRandomSizes) {
    EXPECT_TRUE(rc::check([] {
        const auto rows = *rc::gen::inRange<std::int64_t>(1, 70);
        const auto cols = *rc::gen::inRange<std::int64_t>(1, 600);
        const int order = *rc::gen::inRange(1, 5);
        const int levels = *rc::gen::inRange(0, 5);
        const auto data = noise_grid<double>(rows, cols, 3);
        const auto pyramid = analysed(data, spec_of(order, Family::Compact, 0, levels));
        RC_ASSERT(largest_difference(data, barycentric::coefficients(pyramid, 0, 0)) < 1e-12);
    }));
}

/// <S z, r> = <z, S^T r>.
TEST(Barycentric, AdjointIsTheTranspose) {
    for (const auto& spec :
         {spec_of(1, Family::Compact, 1, 3), spec_of(2, Family::Compact, 2, 2),
          spec_of(3, Family::SemiOrthogonal, 0, 2), spec_of(4, Family::Compact, 4, 1)}) {
        auto pyramid = Pyramid<double>::allocate(*barycentric::layout(spec, 23, 38, 1));
        auto gradient = Pyramid<double>::allocate(pyramid.layout);
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
            pyramid.bands[k][0] = noise_grid<double>(pyramid.layout.bands[k].box.rows,
                                                     pyramid.layout.bands[k].box.cols, k);
        const auto residual = noise_grid<double>(23, 38, 99);
        barycentric::adjoint<double>(residual.view(), 0, gradient);
        double right = 0;
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
            right += test::dot<double>(pyramid.bands[k][0].view(), gradient.bands[k][0].view());
        const auto surface = barycentric::coefficients(pyramid, 0, 0);
        EXPECT_NEAR(test::dot<double>(surface.view(), residual.view()), right, 1e-10);
    }
}

/// Two vanishing moments and an extension that continues planes. The extension of n samples is
/// straight for n samples only, so the infinite semi-orthogonal filters need a box that is large
/// against the decay of their poles.
TEST(Barycentric, PlanesHaveNoDetails) {
    for (const auto& [spec, n] : {std::pair{spec_of(2, Family::Compact, 2, 3), 40},
                                  {spec_of(2, Family::Compact, 4, 1), 33},
                                  {spec_of(3, Family::Compact, 3, 2), 41},
                                  {spec_of(2, Family::SemiOrthogonal, 0, 1), 150},
                                  {spec_of(3, Family::SemiOrthogonal, 0, 1), 200}}) {
        Grid<double> plane(n, n - 7);
        for (std::int64_t r = 0; r < plane.rows(); ++r)
            for (std::int64_t c = 0; c < plane.cols(); ++c)
                plane(r, c) = 3.0 + 0.25 * static_cast<double>(r) - 0.5 * static_cast<double>(c);
        const auto pyramid = analysed(plane, spec);
        for (std::size_t k = 1; k < pyramid.bands.size(); ++k)
            for (std::int64_t r = 0; r < pyramid.bands[k][0].rows(); ++r)
                for (std::int64_t c = 0; c < pyramid.bands[k][0].cols(); ++c)
                    // Values of size 100, sums of a few hundred products.
                    EXPECT_NEAR(pyramid.bands[k][0](r, c), 0, 1e-11)
                        << pyramid.layout.bands[k].name;
    }
}

template <class T>
void expect_same_bytes(const Grid<T>& a, const Grid<T>& b) {
    for (std::int64_t r = 0; r < a.rows(); ++r)
        EXPECT_EQ(0,
                  std::memcmp(a.row(r), b.row(r), static_cast<std::size_t>(a.cols()) * sizeof(T)));
}

/// Sizes beyond several tiles; the larger ones also write past the caches.
TEST(Barycentric, SameBytesForAnyThreadCountAndKernel) {
    for (const auto& [spec, rows, cols] : {std::tuple{spec_of(2, Family::Compact, 2, 3), 531, 1100},
                                           {spec_of(1, Family::Compact, 1, 3), 1031, 1100},
                                           {spec_of(1, Family::Compact, 1, 1), 1030, 1101},
                                           {spec_of(2, Family::SemiOrthogonal, 0, 1), 301, 420}}) {
        const auto data = noise_grid<float>(rows, cols, 8);
        set_thread_count(1);
        const auto one = analysed(data, spec);
        const auto one_back = barycentric::coefficients(one, 0, 0);
        set_thread_count(3);
        const auto three = analysed(data, spec);
        const auto three_back = barycentric::coefficients(one, 0, 0);
        set_simd_enabled(false);
        const auto scalar = analysed(data, spec);
        const auto scalar_back = barycentric::coefficients(one, 0, 0);
        set_simd_enabled(true);
        set_thread_count(0);
        for (std::size_t k = 0; k < one.bands.size(); ++k) {
            expect_same_bytes(one.bands[k][0], three.bands[k][0]);
            expect_same_bytes(one.bands[k][0], scalar.bands[k][0]);
        }
        expect_same_bytes(one_back, three_back);
        expect_same_bytes(one_back, scalar_back);
        // Noise of size 1 and sums of a few hundred products of float.
        EXPECT_LE(largest_difference(data, one_back), 1e-4);
    }
}

/// Specification section 5: stored coefficients of three levels, in per cent of the samples.
TEST(Barycentric, StorageFollowsTheSpecification) {
    const auto percent = [](int order, int dual, std::int64_t n) {
        const auto layout = *barycentric::layout(spec_of(order, Family::Compact, dual, 3), n, n, 1);
        return 100.0 * static_cast<double>(layout.coefficients()) / static_cast<double>(n * n);
    };
    EXPECT_NEAR(percent(1, 1, 1024), 232.5, 0.05);
    EXPECT_NEAR(percent(2, 2, 1024), 235.6, 0.05);
    EXPECT_NEAR(percent(2, 4, 1024), 238.4, 0.05);
    EXPECT_NEAR(percent(1, 1, 64), 251, 0.5);
    EXPECT_NEAR(percent(2, 2, 64), 309, 0.5);
    EXPECT_NEAR(percent(2, 4, 64), 364, 0.5);
}

/// Specification section 4.4: what the paper's truncated filters leave behind; the semi-orthogonal
/// solves leave nothing.
TEST(Barycentric, TruncatedFiltersReproduceThePapersError) {
    const auto data = noise_grid<double>(128, 128, 77);
    const auto relative_error = [&](Family family) {
        const auto back = barycentric::coefficients(analysed(data, spec_of(2, family, 0, 1)), 0, 0);
        double error = 0, energy = 0;
        for (std::int64_t r = 16; r < 112; ++r)
            for (std::int64_t c = 16; c < 112; ++c) {
                error += std::pow(back(r, c) - data(r, c), 2);
                energy += std::pow(data(r, c), 2);
            }
        return std::sqrt(error / energy);
    };
    EXPECT_NEAR(relative_error(Family::TruncatedLiteral), 8.4e-3, 0.8e-3);
    EXPECT_NEAR(relative_error(Family::TruncatedCorrect), 2.2e-3, 0.3e-3);
    EXPECT_LT(relative_error(Family::SemiOrthogonal), 1e-14);
}

}  // namespace
}  // namespace relief::multires
