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
constexpr std::size_t kChecksumSize = 4;
constexpr int kZstdLevel = 19;
constexpr std::uint64_t kMostChunks = std::uint64_t{1} << 40;
constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 62;
/// All Zstandard frames begin with these bytes; files leave them out.
constexpr std::array<std::uint8_t, 4> kFrameMagic = {0x28, 0xb5, 0x2f, 0xfd};
constexpr double kUnknown = std::numeric_limits<double>::infinity();

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
    std::uint64_t size = 0;          ///< of the preamble itself
    std::uint64_t header_bytes = 0;  ///< compressed
    std::uint64_t directory_bytes = 0;

    [[nodiscard]] std::uint64_t header_end() const { return size + header_bytes; }
    [[nodiscard]] std::uint64_t directory_end() const { return header_end() + directory_bytes; }
    [[nodiscard]] std::uint64_t head_size() const { return directory_end() + kChecksumSize; }
};

void put_preamble(ByteWriter& out, const Preamble& preamble) {
    out.bytes(kMagic);
    out.u16(kContainerVersion);
    out.varint(preamble.header_bytes);
    out.varint(preamble.directory_bytes);
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
    ByteReader in(bytes.subspan(known));
    const std::uint16_t version = in.u16();
    if (!in.failed() && version != kContainerVersion)
        return Error{ErrorCode::Unsupported,
                     "the file has version " + std::to_string(version) +
                         ", this program reads version " + std::to_string(kContainerVersion) +
                         (version < kContainerVersion ? "; it was a trial, encode the data again"
                                                      : "; use a newer one"),
                     "byte 10"};
    Preamble preamble;
    preamble.header_bytes = in.varint();
    preamble.directory_bytes = in.varint();
    preamble.size = bytes.size() - in.rest().size();
    if (in.failed() && bytes.size() < ContainerReader::kLargestPreamble)
        return bad_file("the file ends in its first bytes; fetch it again", bytes.size());
    if (in.failed() || preamble.header_bytes > kLargestFile ||
        preamble.directory_bytes > kLargestFile)
        return bad_file("header or directory claim to be larger than any file", 12);
    return preamble;
}

Result<std::string> unpack_header(std::span<const std::uint8_t> packed, std::uint64_t where) {
    Bytes frame(kFrameMagic.begin(), kFrameMagic.end());
    frame.insert(frame.end(), packed.begin(), packed.end());
    const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
    if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN)
        return bad_file("the header does not say its size", where);
    if (size > kHeaderLimit) return bad_file("the header claims to be over 16 MiB", where);
    std::string header(static_cast<std::size_t>(size), '\0');
    const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                       &ZSTD_freeDCtx);
    const std::size_t unpacked =
        ZSTD_decompress_usingDict(context.get(), header.data(), header.size(), frame.data(),
                                  frame.size(), kHeaderDictionary.data(), kHeaderDictionary.size());
    if (ZSTD_isError(unpacked) || unpacked != header.size())
        return bad_file("the header can not be decompressed", where);
    return header;
}

Bytes pack_header(const std::string& header) {
    Bytes frame(ZSTD_compressBound(header.size()));
    const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                       &ZSTD_freeCCtx);
    frame.resize(ZSTD_compress_usingDict(context.get(), frame.data(), frame.size(), header.data(),
                                         header.size(), kHeaderDictionary.data(),
                                         kHeaderDictionary.size(), kZstdLevel));
    frame.erase(frame.begin(), frame.begin() + kFrameMagic.size());
    return frame;
}

/// Each chunk begins where the last ended, so none overlap and no sum overflows.
Result<std::vector<ChunkInfo>> read_directory(std::span<const std::uint8_t> bytes,
                                              const Preamble& preamble) {
    ByteReader in(bytes);
    std::vector<ChunkInfo> directory;
    std::uint64_t next = preamble.head_size();
    double bound = kUnknown;
    while (!in.rest().empty()) {
        ChunkInfo& chunk = directory.emplace_back();
        const std::uint64_t entry = in.varint();
        if ((entry & 1) != 0) bound = bound_of(in.u16());
        chunk.offset = next;
        chunk.length = entry >> 1;
        chunk.bound = bound;
        if (chunk.length > 0) chunk.checksum = in.u32();
        const std::uint64_t where = preamble.directory_end() - in.rest().size();
        if (in.failed())
            return bad_file("the directory ends inside an entry", preamble.directory_end());
        if (chunk.length > kLargestFile || next > kLargestFile)
            return bad_file("a chunk claims to be larger than any file", where);
        if (!(bound >= 0)) return bad_file("an error bound is negative or not a number", where);
        next += chunk.length;
    }
    return directory;
}

Result<Bytes> pack_directory(const std::vector<ChunkInfo>& chunks) {
    ByteWriter directory;
    std::uint16_t last = bound_code(kUnknown);
    for (const ChunkInfo& chunk : chunks) {
        if (!(chunk.bound >= 0))
            return Error{ErrorCode::InvalidArgument,
                         "an error bound must be a number and not negative", "directory"};
        const std::uint16_t bound = bound_code(chunk.bound);
        directory.varint(2 * chunk.length + (bound != last ? 1 : 0));
        if (bound != last) directory.u16(bound);
        if (chunk.length > 0) directory.u32(chunk.checksum);
        last = bound;
    }
    return directory.take();
}

}  // namespace

std::uint32_t chunk_checksum(std::span<const std::uint8_t> bytes) {
    return static_cast<std::uint32_t>(XXH3_64bits(bytes.data(), bytes.size()));
}

Result<Bytes> container_head(const std::string& header, const std::vector<ChunkInfo>& chunks) {
    if (header.size() > kHeaderLimit)
        return Error{ErrorCode::InvalidArgument, "the header is over 16 MiB; shorten its metadata",
                     "header"};
    if (chunks.size() > kMostChunks)
        return Error{ErrorCode::InvalidArgument, "a file holds at most 2^40 chunks", "directory"};
    const Bytes packed = pack_header(header);
    RELIEF_TRY(const Bytes directory, pack_directory(chunks));
    ByteWriter out;
    put_preamble(out, {.header_bytes = packed.size(), .directory_bytes = directory.size()});
    out.bytes(packed);
    out.bytes(directory);
    Bytes head = out.take();
    ByteWriter sum;
    sum.u32(chunk_checksum(head));
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
    Bytes first(
        static_cast<std::size_t>(std::min<std::uint64_t>(kLargestPreamble, reader.visible_)));
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
    if (chunk_checksum(all.first(preamble.directory_end())) != sum.u32())
        return bad_file("header or directory are damaged: their checksum differs", preamble.size);
    RELIEF_TRY(reader.header_,
               unpack_header(all.subspan(preamble.size, preamble.header_bytes), preamble.size));
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
