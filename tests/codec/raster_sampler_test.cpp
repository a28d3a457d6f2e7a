#include "relief/codec/raster_sampler.h"

#include <array>
#include <limits>
#include <numbers>

#include "codec/landscape.h"
#include "relief/core/parallel.h"

namespace relief::codec {
namespace {

RasterFile encoded(const Raster& raster, const Goal& goal) {
    EncodeOptions options;
    options.goal = goal;
    return *RasterFile::open(encode_raster(raster, options)->bytes);
}

const std::array<Goal, 3> kGoals = {
    {{Goal::Kind::Lossless, 0}, {Goal::Kind::MaxError, 1}, {Goal::Kind::RmsError, 1}}};

Sampling whole(const RasterFile& file) {
    return file.samples_of_level(0, file.box(0));
}

/// Every sample is that of the other raster, holes included.
void expect_same(const Raster& a, const Raster& b) {
    ASSERT_EQ(a.planes.size(), b.planes.size());
    ASSERT_EQ(a.rows, b.rows);
    ASSERT_EQ(a.cols, b.cols);
    for (std::size_t p = 0; p < a.planes.size(); ++p)
        for (std::int64_t r = 0; r < a.rows; ++r)
            for (std::int64_t c = 0; c < a.cols; ++c) {
                ASSERT_EQ(a.valid(r, c), b.valid(r, c));
                if (!a.valid(r, c)) continue;
                ASSERT_EQ(a.planes[p](r, c), b.planes[p](r, c));
            }
}

TEST(RasterSampler, SamplesAreThoseThatAreDecoded) {
    const Raster raster = landscape(150, 130, 2);
    for (const Goal& goal : kGoals) {
        const RasterFile file = encoded(raster, goal);
        RasterSampler sampler(file);
        for (int level = 0; level < 3; ++level) {
            const LatticeBox window{3, 5, 20, 17};
            const auto sampled =
                sampler.values(file.samples_of_level(level, window), SampleType::Float64);
            ASSERT_TRUE(sampled.ok());
            const auto expected = file.decode_window(level, window);
            expect_same(*sampled, expected->raster);
            EXPECT_EQ(sampled->geo, expected->raster.geo);
        }
    }
}

TEST(RasterSampler, ValuesBetweenSamplesAreTheSurfaces) {
    const RasterFile file = encoded(landscape(150, 130), {Goal::Kind::MaxError, 1});
    RasterSampler sampler(file);
    const Sampling places{{10.25, 0.5, 30}, {20.125, 0.25, 40}};
    const auto sampled = sampler.values(places, SampleType::Float64);
    ASSERT_TRUE(sampled.ok());
    const auto surface = RasterSurface::create(file, 0, file.box(0));
    Grid<double> expected(30, 40);
    surface->evaluate_grid(0, 10.25, 0.5, 20.125, 0.25, expected.view());
    for (std::int64_t r = 0; r < 30; ++r)
        for (std::int64_t c = 0; c < 40; ++c) ASSERT_EQ(sampled->planes[0](r, c), expected(r, c));
    const auto rounded = sampler.values(places, SampleType::Int16);
    EXPECT_EQ(rounded->planes[0](7, 9), std::nearbyint(expected(7, 9)));
}

TEST(RasterSampler, TakesTheCoarsestLevelThatIsDenseEnough) {
    const RasterFile file = encoded(landscape(100, 70), {Goal::Kind::MaxError, 1});
    const RasterSampler sampler(file);
    const auto level = [&](std::int64_t rows, std::int64_t cols) {
        const Sampling all = whole(file);
        return sampler.level_for({all.rows.cut(0, 100, rows), all.cols.cut(0, 70, cols)});
    };
    EXPECT_EQ(level(100, 70), 0);
    EXPECT_EQ(level(200, 140), 0);
    EXPECT_EQ(level(51, 35), 0);
    EXPECT_EQ(level(50, 35), 1);
    EXPECT_EQ(level(50, 36), 0);
    // Level 3 has 13 x 9 samples, which are 100/13 apart rather than 8.
    EXPECT_EQ(level(13, 9), 3);
    EXPECT_EQ(level(13, 10), 2);
    EXPECT_EQ(level(1, 1), file.layout().levels());
}

TEST(RasterSampler, PlacesOutsideHaveTheValuesOfTheBorder) {
    const Raster raster = landscape(40, 30);
    const RasterFile file = encoded(raster, {Goal::Kind::Lossless, 0});
    RasterSampler sampler(file);
    const auto sampled = sampler.values({{-3, 1, 3}, {7, 1, 1}}, SampleType::Float64);
    ASSERT_TRUE(sampled.ok());
    // The spline passes through samples up to the rounding of doubles.
    EXPECT_NEAR(sampled->planes[0](0, 0), raster.planes[0](0, 7), 1e-9);
}

TEST(RasterSampler, HolesAreThoseOfTheNearestSample) {
    Raster raster = landscape(60, 50);
    raster.mask = Grid<std::uint8_t>(60, 50, 1);
    for (std::int64_t r = 10; r < 20; ++r)
        for (std::int64_t c = 30; c < 40; ++c) {
            raster.mask(r, c) = 0;
            raster.planes[0](r, c) = std::numeric_limits<double>::quiet_NaN();
        }
    for (const Goal& goal : kGoals) {
        const RasterFile file = encoded(raster, goal);
        RasterSampler sampler(file);
        const Sampling all = whole(file);
        const Sampling halves{all.rows.cut(0, 60, 120), all.cols.cut(0, 50, 100)};
        const auto check = [&](const Result<Raster>& sampled) {
            ASSERT_TRUE(sampled.ok());
            for (std::int64_t r = 0; r < 120; ++r)
                for (std::int64_t c = 0; c < 100; ++c) {
                    ASSERT_EQ(sampled->valid(r, c), raster.valid(r / 2, c / 2));
                    ASSERT_EQ(std::isnan(sampled->planes[0](r, c)), !raster.valid(r / 2, c / 2));
                }
        };
        check(sampler.values(halves, SampleType::Float32));
        check(sampler.derived(Quantity::Slope, halves, *PlaceMap::create({})));
    }
}

/// z = 3 x - 4 y over columns and rows: all quantities in closed form.
TEST(RasterSampler, QuantitiesOfAPlane) {
    Raster raster;
    raster.rows = 40;
    raster.cols = 50;
    raster.type = SampleType::Int16;
    raster.planes.emplace_back(40, 50);
    for (std::int64_t r = 0; r < 40; ++r)
        for (std::int64_t c = 0; c < 50; ++c)
            raster.planes[0](r, c) = static_cast<double>(3 * c + 4 * r);
    GeoReference north_up;
    north_up.transform = {0, 1, 0, 0, 0, -1};
    const PlaceMap ground = *PlaceMap::create(north_up);
    constexpr double degree = std::numbers::pi / 180;
    const std::array<std::pair<Quantity, double>, 5> expected = {
        {{Quantity::Dx, 3},
         {Quantity::Dy, -4},
         {Quantity::Slope, std::atan(5.0) / degree},
         {Quantity::Aspect, 360 - std::atan(0.75) / degree},
         {Quantity::Hillshade, std::nearbyint(1 + 254 * (3.5 + std::sqrt(0.5)) / std::sqrt(26))}}};
    const RasterFile file = encoded(raster, {Goal::Kind::Lossless, 0});
    RasterSampler sampler(file);
    for (const Sampling& places : {whole(file), Sampling{{3.3, 0.7, 20}, {4.1, 1.3, 30}},
                                   file.samples_of_level(2, {0, 0, 10, 13})})
        for (const auto& [quantity, value] : expected) {
            const auto derived = sampler.derived(quantity, places, ground);
            ASSERT_TRUE(derived.ok());
            EXPECT_EQ(derived->type,
                      quantity == Quantity::Hillshade ? SampleType::UInt8 : SampleType::Float32);
            for (std::int64_t r = 0; r < derived->rows; ++r)
                for (std::int64_t c = 0; c < derived->cols; ++c)
                    // Planes are reproduced up to rounding; the result is a float32.
                    ASSERT_NEAR(derived->planes[0](r, c), value, 1e-5 * std::abs(value))
                        << quantity_name(quantity) << " at " << r << ", " << c;
        }
}

TEST(RasterSampler, NamesOfQuantities) {
    for (const char* name : {"value", "dx", "dy", "slope", "aspect", "hillshade"})
        EXPECT_EQ(quantity_name(*quantity_from_name(name)), name);
    const auto unknown = quantity_from_name("height");
    ASSERT_FALSE(unknown.ok());
    EXPECT_NE(unknown.error().message.find("aspect"), std::string::npos);
}

TEST(RasterSampler, SameBitsForAnyNumberOfThreads) {
    const RasterFile file = encoded(landscape(200, 170), {Goal::Kind::MaxError, 1});
    const Sampling places{{0.3, 0.7, 250}, {0.1, 0.9, 180}};
    std::vector<Raster> rasters;
    for (const int threads : {1, 3}) {
        set_thread_count(threads);
        RasterSampler sampler(file);
        rasters.push_back(*sampler.values(places, SampleType::Float64));
        rasters.push_back(*sampler.derived(Quantity::Hillshade, places, *PlaceMap::create({})));
    }
    set_thread_count(0);
    expect_same(rasters[0], rasters[2]);
    expect_same(rasters[1], rasters[3]);
}

TEST(RasterSurface, DamageIsNamed) {
    const Raster raster = landscape(600, 1100);
    EncodeOptions options;
    options.goal = {Goal::Kind::MaxError, 1};
    options.profile = Profile::Fast;
    Bytes bytes = encode_raster(raster, options)->bytes;
    bytes.back() ^= 1;
    const RasterFile file = *RasterFile::open(std::move(bytes));
    int refused = 0;
    for (const std::int64_t col : {0, 900}) {
        const LatticeBox window{100, col, 50, 60};
        const auto surface = RasterSurface::create(file, 0, window);
        const bool damaged = !file.decode_window(0, window)->damaged.empty();
        EXPECT_EQ(surface.ok(), !damaged);
        if (surface.ok()) continue;
        ++refused;
        EXPECT_EQ(surface.error().code, ErrorCode::BadFile);
        EXPECT_NE(surface.error().message.find("--allow-damage"), std::string::npos);
    }
    EXPECT_EQ(refused, 1);
    for (const LatticeBox& window : {LatticeBox{0, 0, 601, 5}, LatticeBox{-1, 0, 5, 5}})
        EXPECT_EQ(RasterSurface::create(file, 0, window).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(RasterSurface::create(file, 60, {0, 0, 1, 1}).error().code,
              ErrorCode::InvalidArgument);
}

TEST(RasterFile, TellsTheRangeOfTheOriginal) {
    const Raster raster = landscape(60, 50);
    double low = raster.planes[0](0, 0);
    double high = low;
    for (std::int64_t r = 0; r < 60; ++r)
        for (std::int64_t c = 0; c < 50; ++c) {
            low = std::min(low, raster.planes[0](r, c));
            high = std::max(high, raster.planes[0](r, c));
        }
    const auto exact = encoded(raster, {Goal::Kind::Lossless, 0}).original_range(0);
    ASSERT_TRUE(exact);
    EXPECT_EQ(*exact, std::pair(low, high));
    const auto lossy = encoded(raster, {Goal::Kind::MaxError, 1}).original_range(0);
    ASSERT_TRUE(lossy);
    // Its unit is a part of the bound.
    EXPECT_NEAR(lossy->first, low, 1);
    EXPECT_NEAR(lossy->second, high, 1);
    EXPECT_FALSE(encoded(raster, {Goal::Kind::RmsError, 1}).original_range(0));
}

}  // namespace
}  // namespace relief::codec
