#include "relief/multires/scheme.h"

#include "relief/multires/edit.h"
#include "support.h"

namespace relief::multires {
namespace {

using test::largest_difference;
using test::noise_grid;

std::vector<SchemeSpec> all_specs() {
    std::vector<SchemeSpec> specs;
    for (const DataMap map : {DataMap::Interpolate, DataMap::Coefficients}) {
        for (const int order : {1, 2})
            specs.push_back({SchemeId::Box, order, Family::Compact, 0, -1, map});
        for (const int order : {1, 2, 3}) {
            specs.push_back({SchemeId::Barycentric, order, Family::Compact, 0, 2, map});
            specs.push_back({SchemeId::Barycentric, order, Family::SemiOrthogonal, 0, 2, map});
        }
    }
    for (const bool exact : {false, true})
        specs.push_back({SchemeId::Cubic, 2, Family::Compact, 0, -1, DataMap::Interpolate, exact});
    return specs;
}

std::string name_of(const SchemeSpec& spec) {
    return std::string(scheme_name(spec.id)) + " order " + std::to_string(spec.order) + " " +
           std::string(family_name(spec.family)) + " " + std::string(data_map_name(spec.data_map)) +
           (spec.exact ? " exact" : "");
}

Grid<double> smooth_grid(std::int64_t rows, std::int64_t cols) {
    Grid<double> grid(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c)
            grid(r, c) =
                std::sin(0.1 * static_cast<double>(r)) * std::cos(0.08 * static_cast<double>(c)) +
                0.1 * static_cast<double>(r);
    return grid;
}

/// The reference norms were measured on a torus; the interior of a raster has the same.
TEST(Scheme, NormsMatchTheReference) {
    const auto norms = test::reference("barycentric.json")["norms"];
    const std::pair<const char*, SchemeSpec> cases[] = {
        {"lw_d1", {SchemeId::Box, 1, Family::Compact, 0, 3, DataMap::Coefficients}},
        {"lw_d2", {SchemeId::Box, 2, Family::Compact, 0, 3, DataMap::Coefficients}},
        {"frame_cdf11", {SchemeId::Barycentric, 1, Family::Compact, 1, 3, DataMap::Coefficients}},
        {"frame_cdf22", {SchemeId::Barycentric, 2, Family::Compact, 2, 3, DataMap::Coefficients}}};
    for (const auto& [name, spec] : cases) {
        const auto bands = layout(spec, 256, 256, 1);
        ASSERT_TRUE(bands.ok());
        ASSERT_EQ(bands->bands.size(), norms[name].size());
        for (std::size_t k = 0; k < bands->bands.size(); ++k)
            EXPECT_NEAR(norms[name][k].get<double>(), bands->bands[k].norm_surface, 1e-9)
                << name << ' ' << k;
    }
}

/// Deeper levels than the measured ones double the norm.
TEST(Scheme, NormsOfDeepLevelsAreThoseOfTheirAtoms) {
    SchemeSpec spec{SchemeId::Box, 2, Family::Compact, 0, 5, DataMap::Interpolate};
    auto pyramid = Pyramid<double>::allocate(*layout(spec, 1025, 1025, 1));
    for (auto& band : pyramid.bands)
        for (std::int64_t r = 0; r < band[0].rows(); ++r)
            std::fill_n(band[0].row(r), band[0].cols(), 0.0);
    pyramid.bands[1][0](16, 16) = 1;
    const auto samples = synthesise(pyramid);
    const double norm = std::sqrt(test::dot<double>(samples[0].view(), samples[0].view()));
    EXPECT_NEAR(norm / pyramid.layout.bands[1].norm_samples, 1, 2e-3);
}

TEST(Scheme, SynthesisGivesTheSamplesBack) {
    for (const SchemeSpec& spec : all_specs())
        for (const auto& [rows, cols] :
             {std::pair{1, 1}, {1, 7}, {5, 1}, {2, 3}, {9, 14}, {33, 50}}) {
            std::vector<Grid<double>> planes;
            std::vector<GridView<const double>> views;
            for (unsigned c = 0; c < 3; ++c)
                planes.push_back(noise_grid<double>(rows, cols, c + 1));
            for (const auto& plane : planes) views.push_back(plane.view());
            SchemeSpec fitting = spec;
            if (spec.id == SchemeId::Box) fitting.levels = -1;
            const auto pyramid = analyse<double>(views, fitting);
            ASSERT_TRUE(pyramid.ok()) << pyramid.error().text();
            const auto back = synthesise(*pyramid);
            ASSERT_EQ(back.size(), 3U);
            // The prefilter may enlarge noise 50 times (order 3: 15), the border extension 3 times
            // a level.
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_LT(largest_difference(planes[c], back[c]), 1e-10)
                    << name_of(spec) << ' ' << rows << " x " << cols;
        }
}

TEST(Scheme, LevelsSampleTheSameSurface) {
    const auto data = smooth_grid(65, 97);
    for (const SchemeSpec& spec : all_specs()) {
        const auto pyramid = analyse<double>({data.view()}, spec);
        ASSERT_TRUE(pyramid.ok());
        for (int level = 0; level <= 2; ++level) {
            const auto coarse = synthesise(*pyramid, level);
            const std::int64_t step = std::int64_t{1} << level;
            ASSERT_EQ(coarse[0].rows(), (65 + step - 1) / step);
            ASSERT_EQ(coarse[0].cols(), (97 + step - 1) / step);
            for (std::int64_t r = 4; r < coarse[0].rows() - 4; ++r)
                for (std::int64_t c = 4; c < coarse[0].cols() - 4; ++c)
                    // Chords 4 samples long miss a wave of 0.1 radians a sample by (0.4)^2 / 8 =
                    // 0.02; samples taken for coefficients are smoothed, at order 3 by half the
                    // variance 1/2 of M_333 times (0.4)^2 + (0.32)^2.
                    EXPECT_NEAR(coarse[0](r, c), data(r * step, c * step), 0.07)
                        << name_of(spec) << " level " << level;
        }
    }
}

/// <S z, r> = <z, S^T r> including the data map.
TEST(Scheme, AdjointIsTheTranspose) {
    for (const SchemeSpec& spec : all_specs()) {
        const auto bands = layout(spec, 21, 30, 1);
        auto pyramid = Pyramid<double>::allocate(*bands);
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
            pyramid.bands[k][0] =
                noise_grid<double>(bands->bands[k].box.rows, bands->bands[k].box.cols, k + 3);
        const auto residual = noise_grid<double>(21, 30, 77);
        const auto gradient = adjoint<double>(*bands, {residual.view()});
        const auto samples = synthesise(pyramid);
        double right = 0;
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
            right += test::dot<double>(pyramid.bands[k][0].view(), gradient.bands[k][0].view());
        const double left = test::dot<double>(samples[0].view(), residual.view());
        EXPECT_NEAR(left, right, 1e-11 * (1 + std::abs(left)) * 100) << name_of(spec);
    }
}

TEST(Scheme, SubdivisionIsSynthesisWithoutDetails) {
    for (const SchemeSpec& spec : all_specs()) {
        auto pyramid = *analyse<double>({noise_grid<double>(40, 31, 9).view()}, spec);
        for (std::size_t k = 1; k < pyramid.bands.size(); ++k)
            for (std::int64_t r = 0; r < pyramid.bands[k][0].rows(); ++r)
                std::fill_n(pyramid.bands[k][0].row(r), pyramid.bands[k][0].cols(), 0.0);
        const int levels = pyramid.layout.levels();
        auto coarse = coefficients(pyramid, levels);
        const auto fine = subdivide(pyramid.layout, std::move(coarse), levels, 0);
        EXPECT_LT(largest_difference(fine.planes[0], coefficients(pyramid, 0).planes[0]), 1e-12)
            << name_of(spec);
    }
}

TEST(Scheme, RefusesWhatItCanNotDo) {
    EXPECT_EQ(layout({}, 0, 5, 1).error().code, ErrorCode::BadInput);
    EXPECT_EQ(layout({}, 5, std::int64_t{1} << 32, 1).error().code, ErrorCode::BadInput);
    EXPECT_EQ(layout({}, 5, 5, 5).error().code, ErrorCode::BadInput);
    EXPECT_EQ(layout({.order = 3}, 5, 5, 1).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(layout({.levels = 40}, 5, 5, 1).error().code, ErrorCode::InvalidArgument);
    EXPECT_NE(scheme_from_name("wavelet").error().message.find("barycentric, box, cubic"),
              std::string::npos);
    EXPECT_EQ(analyse<double>({}, {}).error().code, ErrorCode::BadInput);
}

// --- editing
// ------------------------------------------------------------------------------------------------------

/// Adding delta to a scaling coefficient adds delta * M(2^-m . - x): known supports, known values.
TEST(Edit, MoveAddsOneBoxSpline) {
    const int supports[2][3] = {{7, 37, 169}, {37, 169, 721}};
    const int fine_supports[2][3] = {{7, 37, 169}, {19, 127, 631}};
    for (const SchemeSpec& spec : all_specs()) {
        if (spec.order > 2 || spec.id == SchemeId::Cubic) continue;
        const auto bands = *layout(spec, 97, 97, 1);
        for (int level = 1; level <= std::min(3, bands.levels()); ++level) {
            const Move move{level, 48 >> level, 48 >> level, {2.5}};
            const auto field = displacement<double>(bands, {move}, 0);
            const auto samples = samples_of(bands, field, 0);
            int touched = 0;
            double sum = 0;
            const LatticeBox box = touched_box(bands, {move});
            for (std::int64_t r = 0; r < 97; ++r)
                for (std::int64_t c = 0; c < 97; ++c) {
                    touched += samples[0](r, c) != 0;
                    sum += samples[0](r, c);
                    if (samples[0](r, c) != 0) {
                        EXPECT_TRUE(box.contains(r, c));
                    }
                }
            const bool values = spec.data_map == DataMap::Interpolate;
            EXPECT_EQ(touched, (values ? supports : fine_supports)[spec.order - 1][level - 1])
                << name_of(spec) << level;
            // Integer translates of M sum to 1, so the samples of one scaled M sum to 4^level.
            EXPECT_NEAR(sum, 2.5 * std::pow(4, level), 1e-11);
        }
    }
}

/// Adding delta to a value adds delta * cardinal spline: 1 there, 0 at the other lattice points of
/// the level, nothing beyond 11 (2^level - 1) samples.
TEST(Edit, MoveAddsOneCardinalSpline) {
    const auto bands = *layout({.id = SchemeId::Cubic}, 150, 140, 1);
    for (int level = 1; level <= 3; ++level) {
        const std::int64_t step = std::int64_t{1} << level;
        const Move move{level, 64 / step, 72 / step, {2.5}};
        const auto field = displacement<double>(bands, {move}, 0).planes[0].clone();
        const LatticeBox box = touched_box(bands, {move});
        const std::int64_t reach = 11 * (step - 1);
        const std::int64_t top = std::max<std::int64_t>(64 - reach, 0);
        const std::int64_t left = std::max<std::int64_t>(72 - reach, 0);
        EXPECT_EQ(box, (LatticeBox{top, left, std::min<std::int64_t>(64 + reach, 149) - top + 1,
                                   std::min<std::int64_t>(72 + reach, 139) - left + 1}));
        for (std::int64_t r = 0; r < 150; ++r)
            for (std::int64_t c = 0; c < 140; ++c) {
                if (r % step == 0 && c % step == 0) {
                    EXPECT_EQ(field(r, c), r == 64 && c == 72 ? 2.5 : 0.0);
                }
                if (field(r, c) != 0) {
                    EXPECT_TRUE(box.contains(r, c)) << r << ' ' << c;
                }
            }
        if (level == 3) continue;  // cut at the raster
        EXPECT_NE(field(64, box.col0), 0) << "the box is not too large";
        EXPECT_NE(field(box.row0, 72), 0);
    }
    const auto exact = *layout({.id = SchemeId::Cubic, .exact = true}, 50, 60, 1);
    EXPECT_EQ(touched_box(exact, {{1, 9, 9, {1}}}), (LatticeBox{0, 0, 50, 60}));
}

TEST(Edit, MovingThePyramidEqualsAddingTheDisplacement) {
    for (const SchemeSpec& spec : all_specs()) {
        auto pyramid = *analyse<double>(
            {noise_grid<double>(45, 52, 4).view(), noise_grid<double>(45, 52, 5).view()}, spec);
        const auto before = coefficients(pyramid, 0);
        std::vector<Grid<double>> finest_details;
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
            if (pyramid.layout.bands[k].level == 1)
                finest_details.push_back(pyramid.bands[k][0].clone());
        const std::vector<Move> moves = {
            {1, 5, 9, {3, -1}}, {2, 4, 4, {-2, 0.5}}, {1, 0, 0, {1, 1}}};
        ASSERT_TRUE(apply_moves(pyramid, moves).ok());
        const auto after = coefficients(pyramid, 0);
        const auto change = displacement<double>(pyramid.layout, moves, 0);
        for (std::size_t c = 0; c < 2; ++c)
            for (std::int64_t r = 0; r < 45; ++r)
                for (std::int64_t k = 0; k < 52; ++k)
                    EXPECT_NEAR(after.planes[c](r, k),
                                before.planes[c](r, k) + change.planes[c](r, k), 1e-10)
                        << name_of(spec);
        std::size_t d = 0;
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k)
            if (pyramid.layout.bands[k].level == 1) {
                EXPECT_EQ(largest_difference(pyramid.bands[k][0], finest_details[d++]), 0)
                    << "details are kept";
            }
    }
}

TEST(Edit, MovesThatDoNotExistAreRefusedAndChangeNothing) {
    auto pyramid = *analyse<double>({noise_grid<double>(20, 20, 6).view()}, SchemeSpec{});
    const auto before = coefficients(pyramid, 0);
    EXPECT_EQ(apply_moves(pyramid, {{1, 2, 2, {1}}, {99, 0, 0, {1}}}).error().code,
              ErrorCode::InvalidArgument);
    EXPECT_EQ(apply_moves(pyramid, {{1, 2, 2, {1}}, {1, -1, 0, {1}}}).error().code,
              ErrorCode::InvalidArgument);
    EXPECT_EQ(largest_difference(before.planes[0], coefficients(pyramid, 0).planes[0]), 0);
}

}  // namespace
}  // namespace relief::multires
