#include "codec/pyramid_tiles.h"

#include <gtest/gtest.h>

#include <utility>

#include "codec/pyramid_encode.h"
#include "landscape.h"
#include "relief/codec/container.h"
#include "relief/codec/measure.h"
#include "relief/core/parallel.h"

/// The open loop in tiles: files are as good as those that are made in memory.
namespace relief::codec {
namespace {

using multires::SchemeId;
using multires::SchemeSpec;
using Kind = Goal::Kind;

const SchemeSpec kCubic{.id = SchemeId::Cubic};

Result<EncodedRaster> in_tiles(const Raster& raster, const EncodeOptions& options) {
    MemorySink sink;
    MemorySpool spool;
    EncodedRaster encoded;
    RELIEF_TRY(const std::optional<EncodeReport> report,
               encode_tiles(MemoryRaster(raster), kCubic, options, sink, spool));
    encoded.bytes = sink.take();
    EXPECT_EQ(report.has_value(), !encoded.bytes.empty());
    if (report) encoded.report = *report;
    return encoded;
}

/// 3 x 2 tiles, in two blocks.
const Raster& tall() {
    static const Raster raster = landscape(1300, 900);
    return raster;
}

/// Holes: a third of the raster, wider than what a block looks at, a rectangle across the border of
/// blocks, and every 97th sample.
Raster with_holes(Raster raster) {
    raster.mask = Grid<std::uint8_t>(raster.rows, raster.cols, 1);
    raster.nodata = -9999;
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c) {
            const bool hole = c > 2 * raster.cols / 3 ||
                              (r > 950 && r < 1090 && c > 300 && c < 420) ||
                              (r * raster.cols + c) % 97 == 0;
            if (!hole) continue;
            raster.mask(r, c) = 0;
            for (Grid<double>& plane : raster.planes) plane(r, c) = std::nan("");
        }
    return raster;
}

/// What the report and the file say of its errors is what decoding gives.
void expect_truth(const Raster& raster, const EncodedRaster& encoded) {
    const auto file = RasterFile::open(encoded.bytes);
    ASSERT_TRUE(file.ok()) << file.error().text();
    const Raster decoded = *file->decode(0);
    const Measure found = *measure(raster, decoded);
    EXPECT_EQ(found.max_error, encoded.report.max_error);
    // Summed in another order.
    EXPECT_NEAR(found.rms_error, encoded.report.rms_error, 1e-9 * found.rms_error);
    EXPECT_EQ(encoded.report.bytes, encoded.bytes.size());
    // The header states four digits, rounded up.
    EXPECT_GE(file->max_error(), found.max_error);
    EXPECT_LE(file->max_error(), 1.001 * found.max_error);
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            ASSERT_EQ(decoded.valid(r, c), raster.valid(r, c)) << r << " " << c;
    for (int level = 1; level <= file->layout().levels(); ++level) {
        const Raster coarse = *file->decode(level);
        double largest = 0;
        for (std::size_t p = 0; p < coarse.planes.size(); ++p)
            for (std::int64_t r = 0; r < coarse.rows; ++r)
                for (std::int64_t c = 0; c < coarse.cols; ++c) {
                    ASSERT_EQ(coarse.valid(r, c), raster.valid(r << level, c << level));
                    if (coarse.valid(r, c))
                        largest =
                            std::max(largest, std::abs(coarse.planes[p](r, c) -
                                                       raster.planes[p](r << level, c << level)));
                }
        ASSERT_TRUE(file->bound(level).has_value());
        EXPECT_LE(largest, *file->bound(level)) << "level " << level;
    }
}

TEST(PyramidTiles, AsSmallAsInMemory) {
    const EncodeOptions options{.goal = {Kind::RmsError, 0.9}};
    const auto tiles = in_tiles(tall(), options);
    ASSERT_TRUE(tiles.ok()) << tiles.error().text();
    expect_truth(tall(), *tiles);
    EXPECT_LE(tiles->report.rms_error, 0.9);
    EXPECT_GE(tiles->report.rms_error, 0.99 * 0.9);
    const auto whole = *encode_pyramid(tall(), kCubic, options);
    // Both stop within 1 % of the error, which is about 1 % of the bytes.
    EXPECT_NEAR(static_cast<double>(tiles->bytes.size()), static_cast<double>(whole.bytes.size()),
                0.015 * static_cast<double>(whole.bytes.size()));
    EXPECT_NEAR(tiles->report.energy_percent, whole.report.energy_percent,
                0.03 * whole.report.energy_percent);
    // Bounds of levels say the same of nearly the same surfaces.
    const auto one = *RasterFile::open(tiles->bytes);
    const auto other = *RasterFile::open(whole.bytes);
    ASSERT_EQ(one.layout().levels(), other.layout().levels());
    for (int level = 1; level <= one.layout().levels(); ++level)
        EXPECT_NEAR(*one.surface_bound(level), *other.surface_bound(level),
                    0.05 * *other.surface_bound(level) + 4 * 0.9);
}

TEST(PyramidTiles, HolesAndComponents) {
    const Raster raster = with_holes(landscape(1300, 600, 2));
    for (const Effort effort : {Effort::Select, Effort::Refit}) {
        const EncodeOptions options{.goal = {Kind::Bytes, 60000}, .effort = effort};
        const auto tiles = in_tiles(raster, options);
        ASSERT_TRUE(tiles.ok()) << tiles.error().text();
        expect_truth(raster, *tiles);
        EXPECT_LE(tiles->bytes.size(), 60000U);
        EXPECT_GE(tiles->bytes.size(), 59000U);
    }
}

TEST(PyramidTiles, LayersHaveTheirBounds) {
    const auto tiles = *in_tiles(tall(), {.goal = {Kind::RmsError, 0.5}, .effort = Effort::Select});
    const ContainerReader container = *ContainerReader::open(tiles.bytes);
    int ends = 0;
    for (const ChunkInfo& chunk : container.chunks()) {
        if (!std::isfinite(chunk.bound)) continue;
        ++ends;
        const auto file = RasterFile::open(std::make_shared<MemorySource>(tiles.bytes),
                                           chunk.offset + chunk.length);
        ASSERT_TRUE(file.ok());
        const Measure found = *measure(tall(), *file->decode(0));
        EXPECT_LE(found.max_error, *file->bound(0));
        EXPECT_GE(found.max_error, *file->bound(0) * (1 - 0x1p-6));  // 8 bits, rounded up
    }
    EXPECT_GE(ends, 3);
}

TEST(PyramidTiles, SameBytesForAnyThreadCount) {
    std::vector<Bytes> files;
    for (const int threads : {1, 3}) {
        set_thread_count(threads);
        files.push_back(
            in_tiles(tall(), {.goal = {Kind::RmsError, 3}, .effort = Effort::Select})->bytes);
    }
    set_thread_count(0);
    EXPECT_EQ(files[0], files[1]);
}

TEST(PyramidTiles, ConstantRaster) {
    Raster raster;
    raster.rows = raster.cols = 1100;
    raster.planes.emplace_back(1100, 1100, 7.0);
    for (const Goal goal : {Goal{Kind::RmsError, 0.1}, Goal{Kind::Bytes, 5000}}) {
        const auto tiles = in_tiles(raster, {.goal = goal});
        ASSERT_TRUE(tiles.ok()) << tiles.error().text();
        EXPECT_EQ(tiles->report.max_error, 0);
        EXPECT_LT(tiles->bytes.size(), 600U);
    }
}

TEST(PyramidTiles, Refusals) {
    const auto error_of = [](const Raster& raster, Goal goal) {
        const auto encoded = in_tiles(raster, {.goal = goal, .effort = Effort::Select});
        return encoded.ok() ? std::string() : encoded.error().text();
    };
    Raster raster = landscape(800, 800);
    EXPECT_NE(error_of(raster, {Kind::Bytes, 40}).find("no file is that small"), std::string::npos);
    raster.planes[0](790, 3) = HUGE_VAL;
    EXPECT_NE(error_of(raster, {Kind::RmsError, 1}).find("row 790, column 3"), std::string::npos);
    raster.mask = Grid<std::uint8_t>(800, 800, 0);
    EXPECT_NE(error_of(raster, {Kind::RmsError, 1}).find("no sample is valid"), std::string::npos);
    int calls = 0;
    const auto cancelled = in_tiles(
        tall(), {.goal = {Kind::RmsError, 1}, .progress = [&](double) { return ++calls < 6; }});
    EXPECT_EQ(cancelled.error().code, ErrorCode::Cancelled);
    EXPECT_EQ(calls, 6);
}

/// Quantising ends 2^29 steps below the largest coefficient; then files are exact.
TEST(PyramidTiles, ErrorsThatAreTooSmallAreZero) {
    Raster raster = landscape(1100, 1000);
    raster.type = SampleType::Float64;
    const EncodeOptions options{.goal = {Kind::RmsError, 1e-9}, .effort = Effort::Select};
    const auto tiles = in_tiles(raster, options);
    ASSERT_TRUE(tiles.ok()) << tiles.error().text();
    EXPECT_TRUE(tiles->bytes.empty());
    const auto encoded = encode_raster(raster, options);
    ASSERT_TRUE(encoded.ok()) << encoded.error().text();
    EXPECT_EQ(encoded->report.rms_error, 0);
    const Measure found = *measure(raster, *RasterFile::open(encoded->bytes)->decode(0));
    EXPECT_EQ(found.max_error, 0);
}

TEST(PyramidTiles, WhatFits) {
    Raster about;
    about.rows = about.cols = 800;
    const auto fits = [&](const SchemeSpec& spec, Goal goal) {
        return fits_tiles(about, 1, spec, goal);
    };
    EXPECT_TRUE(fits(kCubic, {Kind::RmsError, 1}));
    EXPECT_TRUE(fits(kCubic, {Kind::Bytes, 1000}));
    EXPECT_FALSE(fits(kCubic, {Kind::RmsError, 0}));
    EXPECT_FALSE(fits(kCubic, {Kind::MaxError, 1}));
    EXPECT_FALSE(fits(kCubic, {Kind::Keep, 1}));
    EXPECT_FALSE(fits({.id = SchemeId::Box}, {Kind::RmsError, 1}));
    EXPECT_FALSE(fits({.id = SchemeId::Cubic, .levels = 3}, {Kind::RmsError, 1}));
    EXPECT_FALSE(fits({.id = SchemeId::Cubic, .exact = true}, {Kind::RmsError, 1}));
    about.rows = 20;
    EXPECT_FALSE(fits(kCubic, {Kind::RmsError, 1}));
    about.rows = 700;
    about.cols = 700;
    EXPECT_FALSE(fits(kCubic, {Kind::RmsError, 1}));
}

}  // namespace
}  // namespace relief::codec
