#include "codec/level_chunks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace relief::codec {
namespace {

/// Two levels over the base, one chunk behind them; chunk k has 10 + k bytes, edits none.
constexpr LevelChunks kChunks = {.levels = 2, .trailing = 1};

Bytes file_of_levels() {
    ContainerWriter writer;
    writer.add({});
    for (std::uint8_t k = 1; k < kChunks.count(); ++k) writer.add(Bytes(10 + k, k), 1.0 / k);
    return *writer.finish("{}");
}

ContainerReader opened(std::uint64_t missing = 0) {
    const Bytes bytes = file_of_levels();
    return *ContainerReader::open(std::make_shared<MemorySource>(bytes), bytes.size() - missing);
}

TEST(LevelChunks, AreNumberedFromTheCoarsest) {
    EXPECT_EQ(kChunks.of_level(2), 2U);
    EXPECT_EQ(kChunks.of_level(1), 3U);
    EXPECT_EQ(kChunks.of_level(0), 4U);
    EXPECT_EQ(kChunks.last_of(1), 3U);
    EXPECT_EQ(kChunks.last_of(0), 5U);
    EXPECT_EQ(kChunks.count(), 6U);
}

TEST(LevelChunks, LevelsNeedTheBytesUpToTheirChunks) {
    const ContainerReader file = opened();
    const std::uint64_t head = file.head_size();
    EXPECT_EQ(bytes_for(file, kChunks, 2), head + 11 + 12);
    EXPECT_EQ(bytes_for(file, kChunks, 1), head + 11 + 12 + 13);
    EXPECT_EQ(bytes_for(file, kChunks, 0), file.complete_size());  // and what stands behind
}

TEST(LevelChunks, TheFinestLevelIsThatOfThePrefix) {
    // The last chunks have 15, 14 and 13 bytes.
    EXPECT_EQ(finest_level(opened(), kChunks), 0);
    EXPECT_EQ(finest_level(opened(1), kChunks), 1);
    EXPECT_EQ(finest_level(opened(15 + 14), kChunks), 1);
    EXPECT_EQ(finest_level(opened(15 + 14 + 1), kChunks), 2);
    EXPECT_EQ(finest_level(opened(15 + 14 + 13 + 12), kChunks), 2);

    const ContainerReader prefix = opened(15 + 14 + 1);
    EXPECT_TRUE(check_complete(prefix, kChunks, 2).ok());
    const Status status = check_complete(prefix, kChunks, 1);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, ErrorCode::BadFile);
    EXPECT_NE(status.error().message.find(std::to_string(bytes_for(prefix, kChunks, 1))),
              std::string::npos);
    EXPECT_TRUE(check_coarsest(prefix, kChunks.last_of(2)).ok());
    EXPECT_FALSE(check_coarsest(opened(15 + 14 + 13 + 1), kChunks.last_of(2)).ok());
}

TEST(LevelChunks, SummariesFollowTheFile) {
    const auto list = summaries(opened(), kChunks, {"base", "tags", "details", {"order"}});
    ASSERT_EQ(list.size(), 6U);
    const std::vector<std::string> kinds = {"edits", "base", "tags", "details", "details", "order"};
    const std::vector<int> levels = {0, 2, 2, 1, 0, 0};
    for (std::size_t k = 0; k < list.size(); ++k) {
        EXPECT_EQ(list[k].kind, kinds[k]);
        EXPECT_EQ(list[k].level, levels[k]);
        EXPECT_EQ(list[k].bytes, k == 0 ? 0 : 10 + k);
    }
}

TEST(LevelChunks, CountsLevelsAndMovesAreChecked) {
    EXPECT_TRUE(check_count(opened(), kChunks).ok());
    EXPECT_FALSE(check_count(opened(), LevelChunks{.levels = 3, .trailing = 1}).ok());
    EXPECT_TRUE(check_level(kChunks, 2).ok());
    EXPECT_FALSE(check_level(kChunks, 3).ok());
    EXPECT_FALSE(check_level(kChunks, -1).ok());
    const ContainerReader file = opened();
    const std::uint64_t always = std::uint64_t{1} << 22;
    const std::uint64_t most = std::max(always, ((file.complete_size() + 1) << 15) - 1);
    EXPECT_TRUE(check_plausible(file, most, "vertices").ok());
    EXPECT_FALSE(check_plausible(file, most + 1, "vertices").ok());
    EXPECT_TRUE(check_move(0, 3, 4, std::vector<double>{1e150, -1e150}).ok());
    EXPECT_FALSE(check_move(0, 4, 4, std::vector<double>{1}).ok());
    EXPECT_FALSE(check_move(0, 3, 4, std::vector<double>{1, 1.1e150}).ok());
    EXPECT_FALSE(check_move(0, 3, 4, std::vector<double>{NAN}).ok());
}

TEST(Edits, ReplaceTheirChunkAndNoOther) {
    const ContainerReader file = opened();
    const Bytes edits = {1, 2, 3};
    const auto edited = with_edits(file, edits);
    ASSERT_TRUE(edited.ok());
    const ContainerReader after = *ContainerReader::open(*edited);
    EXPECT_EQ(after.header(), file.header());
    EXPECT_EQ(*after.chunk(kEditsChunk), edits);
    for (std::size_t k = 1; k < file.chunks().size(); ++k) {
        EXPECT_EQ(*after.chunk(k), *file.chunk(k));
        EXPECT_EQ(after.chunks()[k].bound, file.chunks()[k].bound);
    }
    EXPECT_EQ(*with_edits(after, {}), file_of_levels());
}

TEST(Edits, RecordsHaveOneSize) {
    const Bytes bytes = {7, 0, 0, 0, 255, 255, 255, 255};
    const auto read = [](ByteReader& in, int& level) { level = read_move_level(in); };
    const auto levels = read_records<int>(bytes, 4, read);
    ASSERT_TRUE(levels.ok());
    EXPECT_EQ(*levels, std::vector<int>({7, 1000}));
    const auto cut = read_records<int>(std::span(bytes).first(7), 4, read);
    ASSERT_FALSE(cut.ok());
    EXPECT_EQ(cut.error().code, ErrorCode::BadFile);
}

}  // namespace
}  // namespace relief::codec
