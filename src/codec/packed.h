#pragma once

#include <cstdint>
#include <span>

#include "relief/core/result.h"
#include "relief/core/stream.h"

namespace relief::codec {

/// One Zstandard frame that states its content size.
[[nodiscard]] Bytes pack(std::span<const std::uint8_t> bytes);

/// Errors: BadFile for bytes that are no frame, or one of more than `most` bytes.
[[nodiscard]] Result<Bytes> unpack(std::span<const std::uint8_t> packed, std::uint64_t most,
                                   const char* where);

/// Signed numbers as 0, 1, 2 ..: 0, -1, 1, -2, ..
[[nodiscard]] constexpr std::uint64_t zigzag(std::int64_t n) {
    return (static_cast<std::uint64_t>(n) << 1) ^ static_cast<std::uint64_t>(n >> 63);
}
[[nodiscard]] constexpr std::int64_t unzigzag(std::uint64_t u) {
    return static_cast<std::int64_t>((u >> 1) ^ (0 - (u & 1)));
}

}  // namespace relief::codec
