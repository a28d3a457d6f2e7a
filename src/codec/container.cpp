#include "relief/codec/container.h"

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "codec/bytes.h"
#include "codec/header_dictionary.h"

namespace relief::codec {

namespace {

/// A letter beyond ASCII, both kinds of line end and an end-of-file mark notice transfers in text
/// mode.
constexpr std::array<std::uint8_t, 10> kMagic = {'R', 'E',  'L',  'I',  'E',
                                                 'F', 0x89, '\r', '\n', 0x1a};
constexpr std::size_t kChecksumSize = 8;
constexpr int kZstdLevel = 19;
constexpr std::uint64_t kMostChunks = std::uint64_t{1} << 40;
constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 62;
/// A length, and a bound.
constexpr std::uint64_t kSmallestEntry = 3;

std::uint64_t checksum(std::span<const std::uint8_t> bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

Error bad_file(std::string message, std::uint64_t byte) {
    return {ErrorCode::BadFile, std::move(message), "byte " + std::to_string(byte)};
}

/// The upper half of a float not below x >= 0.
std::uint16_t bound_code(double x) {
    auto f = static_cast<float>(x);
    if (static_cast<double>(f) < x) f = std::nextafter(f, std::numeric_limits<float>::infinity());
    const auto bits = std::bit_cast<std::uint32_t>(f);
    return static_cast<std::uint16_t>((bits >> 16) + ((bits & 0xffff) != 0));
}

double bound_of(std::uint16_t code) {
    return static_cast<double>(std::bit_cast<float>(std::uint32_t{code} << 16));
}

struct Preamble {
    std::uint32_t header_bytes = 0;  ///< compressed
    std::uint32_t header_size = 0;   ///< as JSON text
    std::uint64_t directory_bytes = 0;

    [[nodiscard]] std::uint64_t header_end() const {
        return ContainerReader::kPreambleSize + std::uint64_t{header_bytes};
    }
    [[nodiscard]] std::uint64_t directory_end() const { return header_end() + directory_bytes; }
    [[nodiscard]] std::uint64_t head_size() const { return directory_end() + kChecksumSize; }
};

void put_preamble(ByteWriter& out, const Preamble& preamble) {
    out.bytes(kMagic);
    out.u16(kContainerVersion);
    out.u32(0);  // flags
    out.u32(preamble.header_bytes);
    out.u32(preamble.header_size);
    out.u64(preamble.directory_bytes);
}

Result<Preamble> read_preamble(std::span<const std::uint8_t> bytes) {
    const std::size_t known = std::min(bytes.size(), kMagic.size());
    if (!std::equal(kMagic.begin(), kMagic.begin() + 6, bytes.begin(),
                    bytes.begin() + std::min<std::size_t>(known, 6)))
        return bad_file("this is not a .relief file", 0);
    if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(known),
                    kMagic.begin()))
        return bad_file(
            "the file was altered on its way, perhaps by a transfer in text mode; fetch it again "
            "as binary",
            6);
    if (bytes.size() < ContainerReader::kPreambleSize)
        return bad_file("the file ends in its first 32 bytes; fetch it again", bytes.size());
    ByteReader in(bytes.subspan(kMagic.size()));
    const std::uint16_t version = in.u16();
    const std::uint32_t flags = in.u32();
    if (version != kContainerVersion || flags != 0)
        return Error{ErrorCode::Unsupported,
                     "the file has version " + std::to_string(version) + " with flags " +
                         std::to_string(flags) + ", this program reads version " +
                         std::to_string(kContainerVersion) +
                         (version < kContainerVersion ? "; it was a trial, encode the data again"
                                                      : "; use a newer one"),
                     "byte 10"};
    Preamble preamble;
    preamble.header_bytes = in.u32();
    preamble.header_size = in.u32();
    preamble.directory_bytes = in.u64();
    if (preamble.header_size > kHeaderLimit)
        return bad_file("the header claims to be over 16 MiB", 20);
    if (preamble.directory_bytes > kLargestFile)
        return bad_file("the directory claims to be larger than any file", 24);
    return preamble;
}

Result<std::string> unpack_header(std::span<const std::uint8_t> packed, std::uint32_t size) {
    constexpr std::uint64_t where = ContainerReader::kPreambleSize;
    if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != size)
        return bad_file("the header has not the size it claims", where);
    std::string header(size, '\0');
    const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                       &ZSTD_freeDCtx);
    const std::size_t unpacked = ZSTD_decompress_usingDict(
        context.get(), header.data(), header.size(), packed.data(), packed.size(),
        kHeaderDictionary.data(), kHeaderDictionary.size());
    if (ZSTD_isError(unpacked) || unpacked != header.size())
        return bad_file("the header can not be decompressed", where);
    return header;
}

/// Each chunk begins where the last ended, so none overlap and no sum overflows.
Result<std::vector<ChunkInfo>> read_directory(std::span<const std::uint8_t> bytes,
                                              const Preamble& preamble) {
    ByteReader in(bytes);
    const std::uint64_t count = in.varint();
    if (in.failed() || count > bytes.size() / kSmallestEntry)
        return bad_file("the directory claims more chunks than it holds", preamble.header_end());
    std::vector<ChunkInfo> directory(static_cast<std::size_t>(count));
    std::uint64_t next = preamble.head_size();
    for (ChunkInfo& chunk : directory) {
        chunk.offset = next;
        chunk.length = in.varint();
        chunk.bound = bound_of(in.u16());
        if (chunk.length > 0) chunk.checksum = in.u32();
        const std::uint64_t where = preamble.directory_end() - in.rest().size();
        if (in.failed() || chunk.length > kLargestFile || next > kLargestFile)
            return bad_file("a chunk claims to be larger than any file", where);
        if (!(chunk.bound >= 0))
            return bad_file("an error bound is negative or not a number", where);
        next += chunk.length;
    }
    if (!in.rest().empty())
        return bad_file("the directory is longer than its chunks", preamble.directory_end());
    return directory;
}

}  // namespace

std::uint32_t chunk_checksum(std::span<const std::uint8_t> bytes) {
    return static_cast<std::uint32_t>(checksum(bytes));
}

Result<Bytes> container_head(const std::string& header, const std::vector<ChunkInfo>& chunks) {
    if (header.size() > kHeaderLimit)
        return Error{ErrorCode::InvalidArgument, "the header is over 16 MiB; shorten its metadata",
                     "header"};
    if (chunks.size() > kMostChunks)
        return Error{ErrorCode::InvalidArgument, "a file holds at most 2^40 chunks", "directory"};
    Bytes packed(ZSTD_compressBound(header.size()));
    const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                       &ZSTD_freeCCtx);
    packed.resize(ZSTD_compress_usingDict(context.get(), packed.data(), packed.size(),
                                          header.data(), header.size(), kHeaderDictionary.data(),
                                          kHeaderDictionary.size(), kZstdLevel));
    ByteWriter directory;
    directory.varint(chunks.size());
    for (const ChunkInfo& chunk : chunks) {
        if (!(chunk.bound >= 0))
            return Error{ErrorCode::InvalidArgument,
                         "an error bound must be a number and not negative", "directory"};
        directory.varint(chunk.length);
        directory.u16(bound_code(chunk.bound));
        if (chunk.length > 0) directory.u32(chunk.checksum);
    }
    const Bytes entries = directory.take();
    Preamble preamble;
    preamble.header_bytes = static_cast<std::uint32_t>(packed.size());
    preamble.header_size = static_cast<std::uint32_t>(header.size());
    preamble.directory_bytes = entries.size();
    ByteWriter out;
    put_preamble(out, preamble);
    out.bytes(packed);
    out.bytes(entries);
    Bytes head = out.take();
    ByteWriter sum;
    sum.u64(checksum(head));
    const Bytes tail = sum.take();
    head.insert(head.end(), tail.begin(), tail.end());
    return head;
}

void ContainerWriter::add(std::span<const std::uint8_t> bytes, double bound) {
    directory_.push_back({0, bytes.size(), chunk_checksum(bytes), bound});
    chunks_.insert(chunks_.end(), bytes.begin(), bytes.end());
}

Result<Bytes> ContainerWriter::finish(const std::string& header) const {
    RELIEF_TRY(Bytes file, container_head(header, directory_));
    file.insert(file.end(), chunks_.begin(), chunks_.end());
    return file;
}

Result<ContainerReader> ContainerReader::open(std::shared_ptr<const ByteSource> source,
                                              std::uint64_t visible) {
    ContainerReader reader;
    reader.visible_ = std::min(visible, source->size());
    Bytes first(static_cast<std::size_t>(std::min<std::uint64_t>(kPreambleSize, reader.visible_)));
    RELIEF_CHECK(source->read(0, first));
    RELIEF_TRY(const Preamble preamble, read_preamble(first));
    reader.head_size_ = preamble.head_size();
    if (reader.head_size_ > source->size())
        return bad_file("the file ends before its directory does; fetch it again", source->size());
    if (reader.head_size_ > reader.visible_)
        return bad_file(
            "header and directory need the first " + std::to_string(reader.head_size_) + " bytes",
            reader.visible_);
    Bytes head(static_cast<std::size_t>(reader.head_size_));
    RELIEF_CHECK(source->read(0, head));
    const std::span<const std::uint8_t> all(head);
    ByteReader sum(all.subspan(preamble.directory_end()));
    if (checksum(all.first(preamble.directory_end())) != sum.u64())
        return bad_file("header or directory are damaged: their checksum differs", kPreambleSize);
    RELIEF_TRY(reader.header_, unpack_header(all.subspan(kPreambleSize, preamble.header_bytes),
                                             preamble.header_size));
    RELIEF_TRY(
        reader.directory_,
        read_directory(all.subspan(preamble.header_end(), preamble.directory_bytes), preamble));
    reader.source_ = std::move(source);
    *reader.read_ = reader.head_size_;
    const std::uint64_t end = reader.complete_size();
    if (reader.source_->size() > end)
        return bad_file("there are bytes behind the last chunk; the file is damaged", end);
    return reader;
}

std::uint64_t ContainerReader::complete_size() const {
    return directory_.empty() ? head_size_ : directory_.back().offset + directory_.back().length;
}

bool ContainerReader::complete(std::size_t k) const {
    return directory_[k].offset + directory_[k].length <= visible_;
}

std::size_t ContainerReader::complete_chunks() const {
    const auto end = std::partition_point(
        directory_.begin(), directory_.end(),
        [&](const ChunkInfo& chunk) { return chunk.offset + chunk.length <= visible_; });
    return static_cast<std::size_t>(end - directory_.begin());
}

Result<Bytes> ContainerReader::chunk(std::size_t k) const {
    const ChunkInfo& info = directory_[k];
    if (!complete(k))
        return bad_file("chunk " + std::to_string(k) + " needs the first " +
                            std::to_string(info.offset + info.length) + " bytes of the file",
                        visible_);
    Bytes bytes(static_cast<std::size_t>(info.length));
    RELIEF_CHECK(source_->read(info.offset, bytes));
    *read_ += info.length;
    if (info.length > 0 && chunk_checksum(bytes) != info.checksum)
        return bad_file("chunk " + std::to_string(k) + " is damaged: its checksum differs",
                        info.offset);
    return bytes;
}

bool ContainerReader::checksums_ok() const {
    for (std::size_t k = 0; k < complete_chunks(); ++k)
        if (!chunk(k).ok()) return false;
    return true;
}

}  // namespace relief::codec
