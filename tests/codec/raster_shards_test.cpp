#include "relief/codec/raster_shards.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "../fuzz/shards.h"
#include "landscape.h"
#include "relief/core/parallel.h"

namespace relief::codec {
namespace {

using SourcePointer = std::shared_ptr<const ByteSource>;

Raster heights(std::int64_t rows, std::int64_t cols, SampleType type) {
    Raster raster = landscape(rows, cols);
    raster.type = type;
    Grid<double>& plane = raster.planes[0];
    for (std::int64_t r = 0; r < rows; ++r) stored_row(plane.row(r), cols, type, {}, plane.row(r));
    return raster;
}

SourcePointer planned(const Raster& raster, const EncodeOptions& options) {
    MemorySink sink;
    const Status status = plan_raster(MemoryRaster(raster), options, sink);
    EXPECT_TRUE(status.ok()) << status.error().text();
    return std::make_shared<MemorySource>(sink.take());
}

SourcePointer shard(const RasterPlan& plan, const Raster& raster,
                    std::span<const std::int64_t> tiles) {
    MemorySink sink;
    const Status status = encode_shard(plan, MemoryRaster(raster), tiles, {}, sink);
    EXPECT_TRUE(status.ok()) << status.error().text();
    return std::make_shared<MemorySource>(sink.take());
}

/// A plan, and shards of two tiles each.
std::vector<SourcePointer> cut(const Raster& raster, const EncodeOptions& options) {
    std::vector<SourcePointer> shards{planned(raster, options)};
    const auto plan = RasterPlan::open(shards[0]);
    EXPECT_TRUE(plan.ok()) << plan.error().text();
    const std::span<const std::int64_t> rest(plan->missing_tiles());
    for (std::size_t k = 0; k < rest.size(); k += 2)
        shards.push_back(
            shard(*plan, raster, rest.subspan(k, std::min<std::size_t>(2, rest.size() - k))));
    return shards;
}

Result<Bytes> merged(const std::vector<SourcePointer>& shards) {
    MemorySink sink;
    RELIEF_TRY(const MergeReport report, merge_shards(shards, sink));
    Bytes bytes = sink.take();
    EXPECT_EQ(report.bytes, bytes.size());
    return bytes;
}

EncodeOptions options_of(Goal goal, Profile profile = Profile::Fast) {
    EncodeOptions options;
    options.spec = multires::SchemeSpec{.id = multires::SchemeId::Fvs};
    options.goal = goal;
    options.profile = profile;
    return options;
}

constexpr Goal kLossless{Goal::Kind::Lossless, 0};
constexpr Goal kOne{Goal::Kind::MaxError, 1};

void expect_same_file(const Raster& raster, const EncodeOptions& options) {
    const auto whole = encode_raster(raster, options);
    ASSERT_TRUE(whole.ok()) << whole.error().text();
    ASSERT_TRUE(whole->report.closed_loop);
    std::vector<SourcePointer> shards = cut(raster, options);
    std::reverse(shards.begin(), shards.end());  // in any order
    const auto joined = merged(shards);
    ASSERT_TRUE(joined.ok()) << joined.error().text();
    EXPECT_EQ(*joined, whole->bytes);
}

TEST(RasterShards, JoinToTheFileOfOneProcess) {
    expect_same_file(heights(1100, 1700, SampleType::Float32), options_of(kOne));
    expect_same_file(heights(1100, 1700, SampleType::Int16), options_of(kLossless));
    expect_same_file(heights(800, 1300, SampleType::Float32), options_of(kLossless));
    expect_same_file(heights(800, 1300, SampleType::Int16), options_of(kOne, Profile::Dense));
}

TEST(RasterShards, OfOneTileAndOfManyTiers) {
    expect_same_file(heights(300, 500, SampleType::Int16), options_of(kOne));
    expect_same_file(heights(1, 1, SampleType::Int16), options_of(kLossless));
    expect_same_file(heights(20, 9000, SampleType::Int16), options_of(kLossless));  // 3 tiers
}

TEST(RasterShards, WithHolesOutliersAndSeveralBands) {
    Raster raster = heights(900, 1400, SampleType::Float32);
    raster.planes.push_back(raster.planes[0].clone());
    raster.nodata = -9999;
    raster.unit = "m";
    raster.mask = Grid<std::uint8_t>(900, 1400, 1);
    for (std::int64_t r = 0; r < 900; ++r)
        for (std::int64_t c = 0; c < 1400; ++c)
            if (c < 600 || (r / 40 + c / 40) % 5 == 0) {  // whole tiles, and parts
                raster.mask(r, c) = 0;
                for (Grid<double>& plane : raster.planes) plane(r, c) = NAN;
            }
    for (std::int64_t c = 700; c < 1300; c += 100) raster.planes[1](850, c) = 1e30F;
    raster.mask(850, 700) = 1;
    expect_same_file(raster, options_of(kOne));
}

TEST(RasterShards, OfAnInterpolatedGridHaveItsMargin) {
    Raster raster = heights(700, 1200, SampleType::Float64);
    Grid<double>& plane = raster.planes[0];
    for (std::int64_t r = 0; r < 700; ++r)
        for (std::int64_t c = 0; c + 2 < 1200; c += 2)
            plane(r, c) = c == 0 ? plane(r, 1) : 0.5 * (plane(r, c - 1) + plane(r, c + 1));
    const EncodeOptions options = options_of(kOne);
    const auto whole = encode_raster(raster, options);
    ASSERT_TRUE(whole.ok());
    ASSERT_EQ(RasterFile::open(whole->bytes)->margin().cols, 1);
    expect_same_file(raster, options);
}

TEST(RasterShards, AreTheSameForAnyNumberOfThreads) {
    const Raster raster = heights(800, 1300, SampleType::Int16);
    set_thread_count(1);
    const auto one = merged(cut(raster, options_of(kOne)));
    set_thread_count(3);
    const auto three = merged(cut(raster, options_of(kOne)));
    set_thread_count(0);
    EXPECT_EQ(*one, *three);
}

TEST(RasterShards, TilesCoverTheRasterOnce) {
    const Raster raster = heights(1100, 1700, SampleType::Int16);
    const auto plan = RasterPlan::open(planned(raster, options_of(kLossless)));
    ASSERT_TRUE(plan.ok());
    Grid<std::uint8_t> seen(1100, 1700, 0);
    for (std::int64_t tile = 0; tile < plan->tile_rows() * plan->tile_cols(); ++tile) {
        const LatticeBox box = plan->samples(tile);
        for (std::int64_t r = box.row0; r < box.row0 + box.rows; ++r)
            for (std::int64_t c = box.col0; c < box.col0 + box.cols; ++c) ++seen(r, c);
    }
    for (std::int64_t r = 0; r < 1100; ++r)
        ASSERT_EQ(std::count(seen.row(r), seen.row(r) + 1700, 1), 1700);
}

std::string error_of(const std::vector<SourcePointer>& shards) {
    const auto joined = merged(shards);
    return joined.ok() ? "" : joined.error().text();
}

TEST(RasterShards, SayWhatIsMissing) {
    const Raster raster = heights(800, 1300, SampleType::Int16);
    const auto shards = cut(raster, options_of(kLossless));
    ASSERT_EQ(shards.size(), 4U);
    EXPECT_EQ(error_of({shards[0], shards[1], shards[2]}),
              "no shard has tile 4; add the one that has");
    EXPECT_EQ(error_of({shards[1], shards[2], shards[3]}), "no shard is the plan; add it");
    EXPECT_EQ(error_of({shards[0], shards[1], shards[1]}),
              "shard 3: has tile 0, as shard 2 has; leave one out");
    EXPECT_EQ(error_of({shards[0], shards[0]}), "shard 2: is a second plan; there is one for all");
    const auto others = cut(heights(801, 1300, SampleType::Int16), options_of(kLossless));
    EXPECT_EQ(error_of({shards[0], others[1]}), "shard 2: was made by another plan");
    const auto file = std::make_shared<MemorySource>(encode_raster(raster, {})->bytes);
    EXPECT_EQ(error_of({shards[0], file}),
              "shard 2, header: holds 'raster' and is no shard of a raster");
    EXPECT_FALSE(RasterFile::open(shards[0]).ok());
    EXPECT_FALSE(RasterPlan::open(shards[1]).ok());
}

TEST(RasterShards, RefuseWhatCanNotBeSharded) {
    const Raster raster = heights(300, 300, SampleType::Float32);
    MemorySink sink;
    EncodeOptions options;
    options.goal = {Goal::Kind::RmsError, 1};
    EXPECT_EQ(plan_raster(MemoryRaster(raster), options, sink).error().code,
              ErrorCode::Unsupported);
    options = options_of(kOne);
    options.spec->id = multires::SchemeId::Box;
    EXPECT_EQ(plan_raster(MemoryRaster(raster), options, sink).error().code,
              ErrorCode::Unsupported);
    const auto plan =
        RasterPlan::open(planned(heights(800, 1300, SampleType::Int16), options_of(kLossless)));
    ASSERT_TRUE(plan.ok());
    const std::vector<std::int64_t> first{0};
    EXPECT_EQ(encode_shard(*plan, MemoryRaster(raster), first, {}, sink).error().code,
              ErrorCode::BadInput);
    const Raster same = heights(800, 1300, SampleType::Int16);
    for (const std::vector<std::int64_t>& tiles :
         std::vector<std::vector<std::int64_t>>{{}, {6}, {-1}, {1, 1}})
        EXPECT_EQ(encode_shard(*plan, MemoryRaster(same), tiles, {}, sink).error().code,
                  ErrorCode::InvalidArgument);
}

TEST(RasterShards, DamageIsAnError) {
    const Raster raster = heights(800, 800, SampleType::Int16);
    const auto shards = cut(raster, options_of(kLossless));
    const auto whole = merged(shards);
    std::mt19937 random(7);
    for (const std::size_t which : {std::size_t{0}, std::size_t{1}}) {
        Bytes bytes(shards[which]->size());
        ASSERT_TRUE(shards[which]->read(0, bytes).ok());
        for (int trial = 0; trial < 200; ++trial) {
            Bytes damaged = bytes;
            damaged[random() % damaged.size()] ^= static_cast<std::uint8_t>(1 << random() % 8);
            if (trial % 4 == 0) damaged.resize(random() % damaged.size());
            auto parts = shards;
            parts[which] = std::make_shared<MemorySource>(std::move(damaged));
            EXPECT_FALSE(merged(parts).ok());
        }
    }
}

TEST(RasterShards, AHostileHeaderIsAnErrorOrAnotherFile) {
    const Raster raster = heights(40, 30, SampleType::Float32);
    const auto plan = planned(raster, options_of(kOne));
    Bytes bytes(plan->size());
    ASSERT_TRUE(plan->read(0, bytes).ok());
    const std::string header = ContainerReader::open(bytes)->header();
    fuzz::shard_header(bytes,
                       {reinterpret_cast<const std::uint8_t*>(header.data()), header.size()});
    std::mt19937 random(11);
    for (int trial = 0; trial < 3000; ++trial) {
        Bytes text(header.begin(), header.end());
        for (std::uint32_t edits = 1 + random() % 3; edits > 0; --edits) {
            std::uint8_t& at = text[random() % text.size()];
            constexpr std::string_view likely = "0123456789-.e,[]{}\"";
            at = static_cast<std::uint8_t>(likely[random() % likely.size()]);
        }
        fuzz::shard_header(bytes, text);
    }
}

}  // namespace
}  // namespace relief::codec
