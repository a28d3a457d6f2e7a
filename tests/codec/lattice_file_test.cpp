#include "codec/lattice_file.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "codec/lattice_encode.h"
#include "relief/core/parallel.h"

namespace relief::codec {
namespace {

/// A surface with hills of all sizes, a little noise, and perhaps holes.
Raster landscape(std::int64_t rows, std::int64_t cols, SampleType type, double height,
                 std::uint32_t seed, bool holes) {
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    raster.type = type;
    Grid<double> plane(rows, cols);
    std::uint32_t state = seed * 2654435761U + 1;
    if (holes) raster.mask = Grid<std::uint8_t>(rows, cols);
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c) {
            state = state * 1664525U + 1013904223U;
            const auto x = static_cast<double>(c);
            const auto y = static_cast<double>(r);
            const double wave = std::sin(0.021 * x + 0.3 * seed) * std::cos(0.017 * y) +
                                0.3 * std::sin(0.11 * x - 0.07 * y) +
                                0.02 * static_cast<double>(state >> 16) / 65536;
            plane(r, c) = stored_value(height * wave, type, {});
            if (!holes) continue;
            const bool hole = (x - 30) * (x - 30) + (y - 20) * (y - 20) < 150 || (state >> 24) == 7;
            raster.mask(r, c) = !hole;
            if (hole) plane(r, c) = std::nan("");
        }
    if (holes && raster.valid_count() == 0) {
        raster.mask(0, 0) = 1;
        plane(0, 0) = 1;
    }
    raster.planes.push_back(std::move(plane));
    return raster;
}

struct Coded {
    LatticeEncoding encoding;
    std::shared_ptr<MemorySource> bytes;
};

Coded coded(const Raster& raster, Profile profile, double bound) {
    const MemoryRaster source(raster);
    const auto seen = survey(source, {});
    EXPECT_TRUE(seen.ok());
    LatticeCoding coding;
    coding.profile = profile;
    EXPECT_TRUE(*choose_domains(source, *seen, bound, coding));
    MemorySpool spool;
    Coded result;
    auto encoding = encode_lattice(source, *seen, coding, {profile, bound, true, {}}, spool);
    EXPECT_TRUE(encoding.ok()) << encoding.error().text();
    result.encoding = *std::move(encoding);
    ContainerWriter writer;
    for (const SpooledChunk& chunk : result.encoding.chunks) {
        Bytes bytes(chunk.info.length);
        EXPECT_TRUE(spool.read(chunk.place, bytes).ok());
        writer.add(bytes, chunk.info.bound);
    }
    result.bytes = std::make_shared<MemorySource>(*writer.finish("{}"));
    return result;
}

struct Opened {
    std::unique_ptr<ContainerReader> container;
    std::unique_ptr<LatticeFile> file;
};

Opened opened(const Coded& coded, const Raster& raster,
              std::uint64_t visible = std::numeric_limits<std::uint64_t>::max()) {
    Opened result;
    result.container =
        std::make_unique<ContainerReader>(*ContainerReader::open(coded.bytes, visible));
    auto file =
        LatticeFile::open(*result.container, 0, coded.encoding.coding, raster.rows, raster.cols);
    EXPECT_TRUE(file.ok());
    result.file = *std::move(file);
    return result;
}

double largest_error(const Raster& raster, const LatticeWindow& window, const LatticeBox& box,
                     std::int64_t step) {
    double largest = 0;
    for (std::int64_t r = 0; r < box.rows; ++r)
        for (std::int64_t c = 0; c < box.cols; ++c) {
            const std::int64_t row = (box.row0 + r) * step;
            const std::int64_t col = (box.col0 + c) * step;
            const bool valid = window.mask.empty() || window.mask(r, c);
            EXPECT_EQ(valid, raster.valid(row, col)) << row << " " << col;
            if (valid)
                largest = std::max(largest,
                                   std::abs(window.planes[0](r, c) - raster.planes[0](row, col)));
        }
    return largest;
}

TEST(LatticeFile, KeepsTheBoundAtEveryLevelAndSize) {
    EXPECT_TRUE(rc::check([] {
        const auto rows = *rc::gen::inRange<std::int64_t>(1, 90);
        const auto cols = *rc::gen::inRange<std::int64_t>(1, 90);
        const auto type = *rc::gen::element(SampleType::Int16, SampleType::Float32,
                                            SampleType::UInt8, SampleType::Float64);
        const auto profile = *rc::gen::element(Profile::Fast, Profile::Dense);
        const double bound = *rc::gen::element(0.5, 1.0, 3.7, 20.0);
        const Raster raster =
            landscape(rows, cols, type, 120, *rc::gen::inRange<std::uint32_t>(0, 99),
                      *rc::gen::arbitrary<bool>());
        const Coded file = coded(raster, profile, bound);
        RC_ASSERT(file.encoding.max_error <= bound);
        const Opened open = opened(file, raster);
        for (int level = 0; level <= open.file->tree().levels(); ++level) {
            const LatticeBox box{0, 0, level_size(rows, level), level_size(cols, level)};
            const auto window = open.file->read(level, box);
            RC_ASSERT(window.ok());
            RC_ASSERT(window->known_level <= level);
            RC_ASSERT(largest_error(raster, *window, box, std::int64_t{1} << level) <= bound);
        }
    }));
}

/// Several tiers: 1100 samples are two tiles of tier 0.
TEST(LatticeFile, WindowsAreCropsAcrossTiles) {
    for (const Profile profile : {Profile::Fast, Profile::Dense}) {
        const Raster raster = landscape(1100, 1290, SampleType::Int16, 300, 3, true);
        const Coded file = coded(raster, profile, 2);
        EXPECT_LE(file.encoding.max_error, 2);
        const Opened open = opened(file, raster);
        EXPECT_EQ(open.file->tree().tiers(), 2);
        for (const int level : {0, 1, 3, 4, 6}) {
            const LatticeBox all{0, 0, level_size(1100, level), level_size(1290, level)};
            const auto whole = open.file->read(level, all);
            ASSERT_TRUE(whole.ok());
            EXPECT_LE(largest_error(raster, *whole, all, std::int64_t{1} << level), 2);
            const LatticeBox part{all.rows / 3, all.cols / 4, all.rows / 2, all.cols / 2};
            const Opened fresh = opened(file, raster);
            const auto window = fresh.file->read(level, part);
            ASSERT_TRUE(window.ok());
            for (std::int64_t r = 0; r < part.rows; ++r)
                for (std::int64_t c = 0; c < part.cols; ++c) {
                    const double a = window->planes[0](r, c);
                    const double b = whole->planes[0](part.row0 + r, part.col0 + c);
                    ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b)));
                }
        }
    }
}

TEST(LatticeFile, EveryPrefixDecodesWithinItsBound) {
    const Raster raster = landscape(1030, 780, SampleType::Float32, 300, 5, true);
    const Coded file = coded(raster, Profile::Fast, 0.7);
    const Opened whole = opened(file, raster);
    const LatticeBox all{0, 0, raster.rows, raster.cols};
    const std::size_t chunks = whole.container->chunks().size();
    for (std::size_t k = 0; k < chunks; ++k) {
        const ChunkInfo& chunk = whole.container->chunks()[k];
        const Opened prefix = opened(file, raster, chunk.offset + chunk.length);
        const auto window = prefix.file->read(0, all);
        ASSERT_TRUE(window.ok());
        double largest = 0;  // the mask of a prefix is coarser
        for (std::int64_t r = 0; r < all.rows; ++r)
            for (std::int64_t c = 0; c < all.cols; ++c)
                if (raster.valid(r, c) && !std::isnan(window->planes[0](r, c)))
                    largest = std::max(largest,
                                       std::abs(window->planes[0](r, c) - raster.planes[0](r, c)));
        EXPECT_LE(largest, window->bound) << "chunk " << k;
        if (k + 1 == chunks) {
            EXPECT_LE(window->bound, 0.7 * (1 + 1.0 / 128));  // 8 bits, rounded up
        }
    }
}

TEST(LatticeFile, SameBytesForAnyNumberOfThreads) {
    const Raster raster = landscape(1100, 1100, SampleType::Int16, 300, 3, false);
    const int threads = thread_count();
    Bytes first;
    for (const int n : {1, 2, 5}) {
        set_thread_count(n);
        const Coded file = coded(raster, Profile::Fast, 3);
        Bytes bytes(file.bytes->size());
        ASSERT_TRUE(file.bytes->read(0, bytes).ok());
        if (first.empty()) first = bytes;
        EXPECT_EQ(first, bytes) << n;
    }
    set_thread_count(threads);
}

TEST(LatticeFile, DamageCostsItsTileOnly) {
    const Raster raster = landscape(1100, 1100, SampleType::Int16, 300, 3, false);
    const Coded file = coded(raster, Profile::Fast, 3);
    Bytes bytes(file.bytes->size());
    ASSERT_TRUE(file.bytes->read(0, bytes).ok());
    const Opened whole = opened(file, raster);
    const ChunkInfo& last = whole.container->chunks().back();
    bytes[last.offset + last.length / 2] ^= 0x10;
    Coded altered{file.encoding.coding.domains.empty() ? LatticeEncoding{} : LatticeEncoding{},
                  std::make_shared<MemorySource>(bytes)};
    altered.encoding.coding = file.encoding.coding;
    const Opened open = opened(altered, raster);
    const auto window = open.file->read(0, {0, 0, 1100, 1100});
    ASSERT_TRUE(window.ok());
    ASSERT_EQ(window->damaged.size(), 1U);
    const LatticeBox& where = window->damaged[0];
    double outside = 0;
    double inside = 0;
    for (std::int64_t r = 0; r < 1100; ++r)
        for (std::int64_t c = 0; c < 1100; ++c) {
            const double error = std::abs(window->planes[0](r, c) - raster.planes[0](r, c));
            (where.contains(r, c) ? inside : outside) =
                std::max(where.contains(r, c) ? inside : outside, error);
        }
    EXPECT_LE(outside, 3);
    EXPECT_LE(inside, window->bound);
    EXPECT_GT(inside, 3);
}

}  // namespace
}  // namespace relief::codec
