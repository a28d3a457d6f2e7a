#include "relief/codec/container.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "codec/bytes.h"
#include "codec/header_dictionary.h"

namespace relief::codec {
namespace {

Bytes chunk_bytes(std::size_t k) {
    std::mt19937 engine(static_cast<std::uint32_t>(k));
    Bytes bytes(k * 13 % 40);
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(engine());
    return bytes;
}

double chunk_bound(std::size_t k) {
    return k == 0 ? std::numeric_limits<double>::infinity() : 10.0 / static_cast<double>(k);
}

const std::string kHeader = R"({"scheme":"box","order":2,"levels":7})";

Bytes small_file(std::size_t chunks = 5) {
    ContainerWriter writer;
    for (std::size_t k = 0; k < chunks; ++k) writer.add(chunk_bytes(k), chunk_bound(k));
    return *writer.finish(kHeader);
}

Result<ContainerReader> opened(const Bytes& bytes) {
    return ContainerReader::open(bytes);
}

void expect_contents(const ContainerReader& reader, std::size_t chunks) {
    EXPECT_EQ(reader.header(), kHeader);
    ASSERT_EQ(reader.chunks().size(), chunks);
    for (std::size_t k = 0; k < chunks; ++k) {
        EXPECT_EQ(*reader.chunk(k), chunk_bytes(k));
        // 8 leading bits, rounded up.
        EXPECT_GE(reader.chunks()[k].bound, chunk_bound(k));
        if (k > 0) {
            EXPECT_LE(reader.chunks()[k].bound, chunk_bound(k) * (1 + 1.0 / 128));
        }
    }
}

TEST(Container, GivesBackWhatWasWritten) {
    const Bytes file = small_file();
    const auto reader = opened(file);
    ASSERT_TRUE(reader.ok()) << reader.error().text();
    EXPECT_EQ(reader->complete_chunks(), 5U);
    EXPECT_EQ(reader->complete_size(), file.size());
    EXPECT_TRUE(reader->checksums_ok());
    expect_contents(*reader, 5);
}

TEST(Container, HoldsNoChunksAndEmptyHeaders) {
    const Bytes file = *ContainerWriter().finish("");
    const auto reader = opened(file);
    ASSERT_TRUE(reader.ok()) << reader.error().text();
    EXPECT_EQ(reader->header(), "");
    EXPECT_TRUE(reader->chunks().empty());
    EXPECT_EQ(reader->complete_size(), file.size());
}

TEST(Container, BoundsAreNeverRoundedDown) {
    for (const double bound : {0.0, 1e-40, 1.0, 0.1, 1.0 + 1e-12, 3.4e38, 1e300}) {
        ContainerWriter writer;
        writer.add(Bytes{1}, bound);
        const double read = opened(*writer.finish("{}"))->chunks()[0].bound;
        EXPECT_GE(read, bound);
        if (bound < 1e38 && bound > 1e-37) {
            EXPECT_LE(read, bound * (1 + 1.0 / 128));
        }
    }
}

/// The dictionary is part of the format: the documented text and the one that is compiled in are
/// the same 15229 bytes.
TEST(Container, DictionaryIsTheDocumentedOne) {
    std::ifstream file(std::string(RELIEF_TEST_DATA) + "/../../docs/header-dictionary.txt",
                       std::ios::binary);
    const std::string documented((std::istreambuf_iterator<char>(file)),
                                 std::istreambuf_iterator<char>());
    EXPECT_EQ(documented.size(), 15229U);
    EXPECT_EQ(documented, kHeaderDictionary);
}

TEST(Container, EveryPrefixOpensOnceItsDirectoryIsThere) {
    const Bytes file = small_file();
    const auto whole = opened(file);
    const auto all = std::make_shared<MemorySource>(file);
    for (std::size_t n = 0; n <= file.size(); ++n) {
        // As the beginning of a longer file, and as a file that was cut off.
        const Bytes cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(n));
        for (const auto& reader : {ContainerReader::open(all, n), opened(cut)}) {
            ASSERT_EQ(reader.ok(), n >= whole->head_size()) << n;
            if (!reader.ok()) continue;
            std::size_t complete = 0;
            for (const ChunkInfo& info : whole->chunks())
                complete += info.offset + info.length <= n;
            EXPECT_EQ(reader->complete_chunks(), complete) << n;
            EXPECT_TRUE(reader->checksums_ok());
            for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(reader->chunk(k).ok(), k < complete);
        }
    }
}

TEST(Container, NoticesEveryBitFlip) {
    const Bytes file = small_file();
    for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
        Bytes altered = file;
        altered[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
        const auto reader = opened(altered);
        EXPECT_FALSE(reader.ok() && reader->checksums_ok()) << "bit " << bit;
    }
}

TEST(Container, DamageToOneChunkLeavesTheOthers) {
    Bytes file = small_file();
    const std::uint64_t offset = opened(file)->chunks()[2].offset;
    file[offset] ^= 1;
    const auto reader = opened(file);
    ASSERT_TRUE(reader.ok());
    EXPECT_FALSE(reader->checksums_ok());
    EXPECT_EQ(reader->chunk(2).error().where, "byte " + std::to_string(offset));
    for (const std::size_t k : {0, 1, 3, 4}) EXPECT_TRUE(reader->chunk(k).ok());
}

TEST(Container, SaysWhatIsWrong) {
    const Bytes file = small_file();
    const auto text_of = [](const Bytes& bytes) { return opened(bytes).error().text(); };
    EXPECT_NE(text_of({'P', 'K', 3, 4}).find("not a .relief file"), std::string::npos);

    Bytes newer = file;
    newer[10] = 2;
    EXPECT_EQ(opened(newer).error().code, ErrorCode::Unsupported);
    EXPECT_NE(text_of(newer).find("version 2"), std::string::npos);

    Bytes as_text;  // line ends turned into "\n"
    for (const std::uint8_t b : file)
        if (b != '\r') as_text.push_back(b);
    EXPECT_NE(text_of(as_text).find("text mode"), std::string::npos);

    Bytes longer = file;
    longer.push_back(0);
    EXPECT_EQ(opened(longer).error().code, ErrorCode::BadFile);
}

/// Everything in front of the first chunk, with the sizes and the header given, and no directory.
Bytes head_of(std::uint64_t header_bytes, std::uint64_t directory_bytes, const Bytes& header) {
    ByteWriter out;
    const Bytes file = small_file();
    out.bytes(std::span(file).first(12));
    out.varint(header_bytes);
    out.varint(directory_bytes);
    out.bytes(header);
    Bytes head = out.take();
    const std::uint32_t sum = chunk_checksum(head);
    for (int k = 0; k < 4; ++k) head.push_back(static_cast<std::uint8_t>(sum >> (8 * k)));
    return head;
}

TEST(Container, RefusesSizesBeforeItAllocates) {
    for (const std::uint64_t size :
         {std::uint64_t{1} << 20, std::uint64_t{1} << 62, ~std::uint64_t{0}}) {
        EXPECT_EQ(opened(head_of(size, 0, {})).error().code, ErrorCode::BadFile) << size;
        EXPECT_EQ(opened(head_of(0, size, {})).error().code, ErrorCode::BadFile) << size;
    }
    // A frame header (one segment, eight bytes of size) that claims 2^56 bytes, and one that says
    // nothing of its size.
    const Bytes huge = {0xe0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0};
    EXPECT_NE(opened(head_of(12, 0, huge)).error().message.find("16 MiB"), std::string::npos);
    const Bytes silent = {0x00, 0x00, 1, 0, 0};
    EXPECT_NE(opened(head_of(5, 0, silent)).error().message.find("size"), std::string::npos);
}

/// Equal bounds are stored once, chunks without bytes have no checksum: 3 of the 5 entries below
/// are a single byte.
TEST(Container, EntriesSayOnlyWhatIsNew) {
    ContainerWriter writer;
    const double unknown = std::numeric_limits<double>::infinity();
    for (const double bound : {unknown, unknown, 9.5}) writer.add({}, bound);
    writer.add(Bytes(63, 7), 9.5);
    writer.add({}, 9.5);
    const Bytes file = *writer.finish("");
    const auto reader = opened(file);
    ASSERT_TRUE(reader.ok()) << reader.error().text();
    const Bytes nothing = *ContainerWriter().finish("");
    EXPECT_EQ(file.size() - nothing.size(), 1U + 1 + 3 + 5 + 1 + 63);
    std::vector<double> bounds;
    for (const ChunkInfo& chunk : reader->chunks()) bounds.push_back(chunk.bound);
    EXPECT_EQ(bounds, (std::vector<double>{unknown, unknown, 9.5, 9.5, 9.5}));
    EXPECT_EQ(*reader->chunk(3), Bytes(63, 7));
}

TEST(Container, WriterRefusesBoundsThatAreNone) {
    for (const double bound : {-1.0, std::nan("")}) {
        ContainerWriter writer;
        writer.add(Bytes{1}, bound);
        EXPECT_EQ(writer.finish(kHeader).error().code, ErrorCode::InvalidArgument);
    }
    EXPECT_EQ(ContainerWriter().finish(std::string(kHeaderLimit + 1, ' ')).error().code,
              ErrorCode::InvalidArgument);
}

/// Files of this version must stay readable. (Other versions of zstd may write the header in other
/// bytes.)
TEST(Container, GoldenFileIsReadable) {
    std::ifstream stream(RELIEF_TEST_DATA "/codec_streams.json");
    const auto reader = opened(nlohmann::json::parse(stream)["file"].get<Bytes>());
    ASSERT_TRUE(reader.ok()) << reader.error().text();
    expect_contents(*reader, 3);
}

}  // namespace
}  // namespace relief::codec
