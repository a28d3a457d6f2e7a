#include "codec/packed.h"

#include <zstd.h>

namespace relief::codec {

namespace {
constexpr int kZstdLevel = 19;
}  // namespace

Bytes pack(std::span<const std::uint8_t> bytes) {
    Bytes packed(ZSTD_compressBound(bytes.size()));
    packed.resize(
        ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kZstdLevel));
    return packed;
}

Result<Bytes> unpack(std::span<const std::uint8_t> packed, std::uint64_t most, const char* where) {
    const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > most)
        return Error{ErrorCode::BadFile, "has not the size that the header calls for", where};
    Bytes bytes(static_cast<std::size_t>(size));
    const std::size_t unpacked =
        ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
    if (ZSTD_isError(unpacked) || unpacked != bytes.size())
        return Error{ErrorCode::BadFile, "can not be decompressed; the file is damaged", where};
    return bytes;
}

}  // namespace relief::codec
