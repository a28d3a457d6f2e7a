#include "relief/codec/container.h"

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <memory>

#include "codec/header_dictionary.h"
#include "codec/little_endian.h"

namespace relief::codec {

namespace {

/// A letter beyond ASCII, both kinds of line end and an end-of-file mark notice transfers in text
/// mode.
constexpr std::array<std::uint8_t, 10> kMagic = {'R', 'E',  'L',  'I',  'E',
                                                 'F', 0x89, '\r', '\n', 0x1a};
constexpr std::size_t kEntrySize = 48;
constexpr std::size_t kChecksumSize = 8;
constexpr int kZstdLevel = 19;

std::uint64_t checksum(std::span<const std::uint8_t> bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

Error bad_file(std::string message, std::uint64_t byte) {
    return {ErrorCode::BadFile, std::move(message), "byte " + std::to_string(byte)};
}

/// Infinite: not known.
bool is_error_size(double x) {
    return x >= 0;
}

struct Preamble {
    std::uint32_t header_bytes = 0;  ///< compressed
    std::uint32_t header_size = 0;   ///< as JSON text
    std::uint32_t chunks = 0;

    [[nodiscard]] std::uint64_t header_end() const {
        return ContainerReader::kPreambleSize + std::uint64_t{header_bytes} + kChecksumSize;
    }
    [[nodiscard]] std::uint64_t directory_end() const {
        return header_end() + std::uint64_t{chunks} * kEntrySize + kChecksumSize;
    }
};

void put_preamble(std::vector<std::uint8_t>& out, const Preamble& preamble) {
    out.insert(out.end(), kMagic.begin(), kMagic.end());
    put(out, kContainerVersion);
    put(out, std::uint32_t{0});  // flags
    put(out, preamble.header_bytes);
    put(out, preamble.header_size);
    put(out, preamble.chunks);
    put(out, std::uint32_t{0});  // reserved
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
    const std::uint8_t* at = bytes.data() + kMagic.size();
    const auto version = take<std::uint16_t>(at);
    const auto flags = take<std::uint32_t>(at);
    if (version > kContainerVersion || flags != 0)
        return Error{ErrorCode::Unsupported,
                     "the file has version " + std::to_string(version) + " with flags " +
                         std::to_string(flags) +
                         ", this program reads version 0 with flags 0; use a newer one",
                     "byte 10"};
    Preamble preamble;
    preamble.header_bytes = take<std::uint32_t>(at);
    preamble.header_size = take<std::uint32_t>(at);
    preamble.chunks = take<std::uint32_t>(at);
    if (preamble.header_size > kHeaderLimit)
        return bad_file("the header claims to be over 16 MiB", 20);
    return preamble;
}

Result<std::string> read_header(std::span<const std::uint8_t> bytes, const Preamble& preamble) {
    const auto packed = bytes.subspan(ContainerReader::kPreambleSize, preamble.header_bytes);
    const std::uint8_t* at = packed.data() + packed.size();
    if (checksum(packed) != take<std::uint64_t>(at))
        return bad_file("the header is damaged: its checksum differs",
                        ContainerReader::kPreambleSize);
    if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != preamble.header_size)
        return bad_file("the header has not the size it claims", ContainerReader::kPreambleSize);
    std::string header(preamble.header_size, '\0');
    const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                       &ZSTD_freeDCtx);
    const std::size_t size = ZSTD_decompress_usingDict(
        context.get(), header.data(), header.size(), packed.data(), packed.size(),
        kHeaderDictionary.data(), kHeaderDictionary.size());
    if (ZSTD_isError(size) || size != header.size())
        return bad_file("the header can not be decompressed", ContainerReader::kPreambleSize);
    return header;
}

ChunkInfo take_entry(const std::uint8_t*& at) {
    ChunkInfo chunk;
    chunk.kind = static_cast<ChunkKind>(take<std::uint16_t>(at));
    chunk.level = take<std::uint16_t>(at);
    chunk.index = take<std::uint32_t>(at);
    chunk.offset = take<std::uint64_t>(at);
    chunk.length = take<std::uint64_t>(at);
    chunk.checksum = take<std::uint64_t>(at);
    chunk.bound = take_double(at);
    chunk.rms = take_double(at);
    return chunk;
}

void put_entry(std::vector<std::uint8_t>& out, const ChunkInfo& chunk, std::uint64_t first_chunk) {
    put(out, static_cast<std::uint16_t>(chunk.kind));
    put(out, chunk.level);
    put(out, chunk.index);
    put(out, first_chunk + chunk.offset);
    put(out, chunk.length);
    put(out, chunk.checksum);
    put_double(out, chunk.bound);
    put_double(out, chunk.rms);
}

/// Each chunk begins where the last ended, so none overlap and no sum overflows.
Result<std::vector<ChunkInfo>> read_directory(std::span<const std::uint8_t> bytes,
                                              const Preamble& preamble) {
    const std::uint64_t end = preamble.directory_end();
    const std::uint8_t* sum = bytes.data() + end - kChecksumSize;
    if (checksum(bytes.first(end - kChecksumSize)) != take<std::uint64_t>(sum))
        return bad_file("the directory is damaged: its checksum differs", preamble.header_end());
    std::vector<ChunkInfo> directory;
    directory.reserve(preamble.chunks);
    std::uint64_t next = end;
    for (const std::uint8_t* at = bytes.data() + preamble.header_end();
         directory.size() < preamble.chunks;) {
        const std::uint64_t where = preamble.header_end() + directory.size() * kEntrySize;
        const ChunkInfo chunk = take_entry(at);
        if (chunk.offset != next)
            return bad_file("a chunk does not begin where the last one ends", where + 8);
        if (chunk.length > std::numeric_limits<std::int64_t>::max() - next)
            return bad_file("a chunk claims to be larger than any file", where + 16);
        if (!is_error_size(chunk.bound) || !is_error_size(chunk.rms))
            return bad_file("an error bound is negative or not a number", where + 32);
        next += chunk.length;
        directory.push_back(chunk);
    }
    return directory;
}

}  // namespace

std::string_view chunk_kind_name(ChunkKind kind) {
    switch (kind) {
        case ChunkKind::Level:
            return "details";
        case ChunkKind::Mask:
            return "mask";
        case ChunkKind::Correction:
            return "correction";
        case ChunkKind::Scaling:
            return "scaling";
        case ChunkKind::Edits:
            return "edits";
    }
    return "unknown";
}

Status ContainerWriter::add(const ChunkInfo& info, std::span<const std::uint8_t> bytes) {
    if (!is_error_size(info.bound) || !is_error_size(info.rms))
        return Error{ErrorCode::InvalidArgument, "an error bound must be a number and not negative",
                     "chunk " + std::to_string(directory_.size())};
    ChunkInfo& chunk = directory_.emplace_back(info);
    chunk.offset = chunks_.size();
    chunk.length = bytes.size();
    chunk.checksum = checksum(bytes);
    chunks_.insert(chunks_.end(), bytes.begin(), bytes.end());
    return {};
}

Result<std::vector<std::uint8_t>> ContainerWriter::finish() const {
    if (header_.size() > kHeaderLimit)
        return Error{ErrorCode::InvalidArgument, "the header is over 16 MiB; shorten its metadata",
                     "header"};
    if (directory_.size() > std::numeric_limits<std::uint32_t>::max())
        return Error{ErrorCode::InvalidArgument,
                     "a file holds less than 2^32 chunks; use larger tiles", "directory"};
    std::vector<std::uint8_t> packed(ZSTD_compressBound(header_.size()));
    const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                       &ZSTD_freeCCtx);
    packed.resize(ZSTD_compress_usingDict(context.get(), packed.data(), packed.size(),
                                          header_.data(), header_.size(), kHeaderDictionary.data(),
                                          kHeaderDictionary.size(), kZstdLevel));
    Preamble preamble;
    preamble.header_bytes = static_cast<std::uint32_t>(packed.size());
    preamble.header_size = static_cast<std::uint32_t>(header_.size());
    preamble.chunks = static_cast<std::uint32_t>(directory_.size());

    std::vector<std::uint8_t> out;
    out.reserve(preamble.directory_end() + chunks_.size());
    put_preamble(out, preamble);
    out.insert(out.end(), packed.begin(), packed.end());
    put(out, checksum(packed));
    for (const ChunkInfo& chunk : directory_) put_entry(out, chunk, preamble.directory_end());
    put(out, checksum(out));
    out.insert(out.end(), chunks_.begin(), chunks_.end());
    return out;
}

Result<std::uint64_t> ContainerReader::directory_end(std::span<const std::uint8_t> first_bytes) {
    RELIEF_TRY(const Preamble preamble, read_preamble(first_bytes));
    return preamble.directory_end();
}

Result<ContainerReader> ContainerReader::open(std::span<const std::uint8_t> bytes,
                                              std::uint64_t file_size) {
    RELIEF_TRY(const Preamble preamble, read_preamble(bytes));
    if (preamble.directory_end() > file_size)
        return bad_file("the file ends before its directory does; fetch it again", file_size);
    if (preamble.directory_end() > bytes.size())
        return bad_file("header and directory need the first " +
                            std::to_string(preamble.directory_end()) + " bytes",
                        bytes.size());
    ContainerReader reader;
    reader.bytes_ = bytes;
    RELIEF_TRY(reader.header_, read_header(bytes, preamble));
    RELIEF_TRY(reader.directory_, read_directory(bytes, preamble));
    reader.directory_end_ = preamble.directory_end();
    const std::uint64_t end = reader.complete_size();
    if (file_size > end || bytes.size() > end)
        return bad_file("there are bytes behind the last chunk; the file is damaged", end);
    return reader;
}

std::uint64_t ContainerReader::complete_size() const {
    return directory_.empty() ? directory_end_
                              : directory_.back().offset + directory_.back().length;
}

bool ContainerReader::complete(std::size_t k) const {
    return directory_[k].offset + directory_[k].length <= bytes_.size();
}

std::size_t ContainerReader::complete_chunks() const {
    std::size_t k = 0;
    while (k < directory_.size() && complete(k)) ++k;
    return k;
}

Result<std::span<const std::uint8_t>> ContainerReader::chunk(std::size_t k) const {
    const ChunkInfo& chunk = directory_[k];
    if (!complete(k))
        return bad_file("chunk " + std::to_string(k) + " needs the first " +
                            std::to_string(chunk.offset + chunk.length) + " bytes of the file",
                        bytes_.size());
    const auto bytes = bytes_.subspan(chunk.offset, chunk.length);
    if (checksum(bytes) != chunk.checksum)
        return bad_file("chunk " + std::to_string(k) + " is damaged: its checksum differs",
                        chunk.offset);
    return bytes;
}

bool ContainerReader::checksums_ok() const {
    for (std::size_t k = 0; k < complete_chunks(); ++k)
        if (!chunk(k).ok()) return false;
    return true;
}

}  // namespace relief::codec
