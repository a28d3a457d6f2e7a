#include "relief/codec/container.h"

#include <fstream>

#include "codec/header_dictionary.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

namespace relief::codec {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes chunk_bytes(std::size_t k) {
    std::mt19937 engine(static_cast<std::uint32_t>(k));
    Bytes bytes(k * 13 % 40);
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(engine());
    return bytes;
}

ChunkInfo chunk_info(std::size_t k) {
    ChunkInfo info;
    info.kind = k == 0 ? ChunkKind::Mask : ChunkKind::Level;
    info.level = static_cast<std::uint16_t>(9 - k);
    info.index = static_cast<std::uint32_t>(3 * k);
    if (k > 0) info.bound = 10.0 / static_cast<double>(k);
    info.rms = 0.1;
    return info;
}

const std::string kHeader = R"({"scheme":"box","order":2,"levels":7})";

Bytes small_file(std::size_t chunks = 5) {
    ContainerWriter writer(kHeader);
    for (std::size_t k = 0; k < chunks; ++k)
        EXPECT_TRUE(writer.add(chunk_info(k), chunk_bytes(k)).ok());
    return *writer.finish();
}

TEST(Container, GivesBackWhatWasWritten) {
    const Bytes file = small_file();
    const auto reader = ContainerReader::open(file, file.size());
    ASSERT_TRUE(reader.ok()) << reader.error().text();
    EXPECT_EQ(reader.value().header(), kHeader);
    ASSERT_EQ(reader.value().chunks().size(), 5U);
    EXPECT_EQ(reader.value().complete_chunks(), 5U);
    EXPECT_EQ(reader.value().complete_size(), file.size());
    EXPECT_TRUE(reader.value().checksums_ok());
    for (std::size_t k = 0; k < 5; ++k) {
        const ChunkInfo& info = reader.value().chunks()[k];
        EXPECT_EQ(info.kind, chunk_info(k).kind);
        EXPECT_EQ(info.level, chunk_info(k).level);
        EXPECT_EQ(info.index, chunk_info(k).index);
        EXPECT_EQ(info.bound, chunk_info(k).bound);
        EXPECT_EQ(info.rms, chunk_info(k).rms);
        const auto bytes = reader.value().chunk(k);
        ASSERT_TRUE(bytes.ok());
        EXPECT_EQ(Bytes(bytes.value().begin(), bytes.value().end()), chunk_bytes(k));
    }
}

TEST(Container, HoldsNoChunksAndEmptyHeaders) {
    const Bytes file = *ContainerWriter("").finish();
    const auto reader = ContainerReader::open(file, file.size());
    ASSERT_TRUE(reader.ok()) << reader.error().text();
    EXPECT_EQ(reader.value().header(), "");
    EXPECT_TRUE(reader.value().chunks().empty());
    EXPECT_EQ(reader.value().complete_size(), file.size());
}

/// The dictionary is part of the format: the documented text and the one that is compiled in are
/// the same 7825 bytes.
TEST(Container, DictionaryIsTheDocumentedOne) {
    std::ifstream file(std::string(RELIEF_TEST_DATA) + "/../../docs/header-dictionary.txt",
                       std::ios::binary);
    const std::string documented((std::istreambuf_iterator<char>(file)),
                                 std::istreambuf_iterator<char>());
    EXPECT_EQ(documented.size(), 7825U);
    EXPECT_EQ(documented, kHeaderDictionary);
}

TEST(Container, EveryPrefixOpensOnceItsDirectoryIsThere) {
    const Bytes file = small_file();
    const std::uint64_t end =
        *ContainerReader::directory_end(std::span(file).first(ContainerReader::kPreambleSize));
    const auto whole = ContainerReader::open(file, file.size());
    for (std::size_t n = 0; n <= file.size(); ++n) {
        const auto prefix = std::span(file).first(n);
        // As the beginning of a longer file, and as a file that was cut off.
        for (const std::uint64_t size : {std::uint64_t{file.size()}, std::uint64_t{n}}) {
            const auto reader = ContainerReader::open(prefix, size);
            ASSERT_EQ(reader.ok(), n >= end) << n;
            if (!reader.ok()) continue;
            std::size_t complete = 0;
            for (const ChunkInfo& info : whole.value().chunks())
                complete += info.offset + info.length <= n;
            EXPECT_EQ(reader.value().complete_chunks(), complete) << n;
            EXPECT_TRUE(reader.value().checksums_ok());
            for (std::size_t k = 0; k < 5; ++k)
                EXPECT_EQ(reader.value().chunk(k).ok(), k < complete);
        }
    }
}

TEST(Container, NoticesEveryBitFlip) {
    const Bytes file = small_file();
    for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
        Bytes altered = file;
        altered[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
        const auto reader = ContainerReader::open(altered, altered.size());
        EXPECT_FALSE(reader.ok() && reader.value().checksums_ok()) << "bit " << bit;
    }
}

TEST(Container, DamageToOneChunkLeavesTheOthers) {
    Bytes file = small_file();
    const std::uint64_t offset =
        ContainerReader::open(file, file.size()).value().chunks()[2].offset;
    file[offset] ^= 1;
    const auto reader = ContainerReader::open(file, file.size());
    ASSERT_TRUE(reader.ok());
    EXPECT_FALSE(reader.value().checksums_ok());
    EXPECT_EQ(reader.value().chunk(2).error().where, "byte " + std::to_string(offset));
    for (const std::size_t k : {0, 1, 3, 4}) EXPECT_TRUE(reader.value().chunk(k).ok());
}

TEST(Container, SaysWhatIsWrong) {
    const Bytes file = small_file();
    const auto text_of = [](const Bytes& bytes) {
        return ContainerReader::open(bytes, bytes.size()).error().text();
    };
    EXPECT_NE(text_of({'P', 'K', 3, 4}).find("not a .relief file"), std::string::npos);

    Bytes newer = file;
    newer[10] = 1;
    EXPECT_EQ(ContainerReader::open(newer, newer.size()).error().code, ErrorCode::Unsupported);
    EXPECT_NE(text_of(newer).find("version 1"), std::string::npos);

    Bytes as_text;  // line ends turned into "\n"
    for (const std::uint8_t b : file)
        if (b != '\r') as_text.push_back(b);
    EXPECT_NE(text_of(as_text).find("text mode"), std::string::npos);

    Bytes longer = file;
    longer.push_back(0);
    EXPECT_EQ(ContainerReader::open(longer, longer.size()).error().code, ErrorCode::BadFile);
}

TEST(Container, RefusesSizesBeforeItAllocates) {
    for (const std::size_t field : {16, 20, 24}) {
        Bytes file = small_file();
        for (std::size_t k = 0; k < 4; ++k) file[field + k] = 0xff;
        EXPECT_EQ(ContainerReader::open(file, file.size()).error().code, ErrorCode::BadFile)
            << field;
    }
}

TEST(Container, WriterRefusesBoundsThatAreNone) {
    ContainerWriter writer(kHeader);
    ChunkInfo info;
    info.bound = -1;
    EXPECT_EQ(writer.add(info, {}).error().code, ErrorCode::InvalidArgument);
    info.bound = std::nan("");
    EXPECT_EQ(writer.add(info, {}).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(ContainerWriter(std::string(kHeaderLimit + 1, ' ')).finish().error().code,
              ErrorCode::InvalidArgument);
}

/// Files of this version must stay readable. (Other versions of zstd may write the header in other
/// bytes.)
TEST(Container, GoldenFileIsReadable) {
    std::ifstream stream(RELIEF_TEST_DATA "/codec_streams.json");
    const Bytes file = nlohmann::json::parse(stream)["file"].get<Bytes>();
    const auto reader = ContainerReader::open(file, file.size());
    ASSERT_TRUE(reader.ok()) << reader.error().text();
    EXPECT_EQ(reader.value().header(), kHeader);
    ASSERT_EQ(reader.value().chunks().size(), 3U);
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(reader.value().chunks()[k].bound, chunk_info(k).bound);
        const auto bytes = reader.value().chunk(k);
        ASSERT_TRUE(bytes.ok());
        EXPECT_EQ(Bytes(bytes.value().begin(), bytes.value().end()), chunk_bytes(k));
    }
}

}  // namespace
}  // namespace relief::codec
