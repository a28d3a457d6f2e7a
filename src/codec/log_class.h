#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace relief::codec {

/// Quantises v logarithmically: 0 .. 7, then four classes an octave, at most `last`.
inline std::uint32_t log_class(std::uint32_t v, std::uint32_t last) {
    if (v < 8) return std::min(v, last);
    const auto octave = static_cast<std::uint32_t>(std::bit_width(v)) - 3;
    return std::min(4 * octave + (v >> octave), last);
}

/// The bucket of a magnitude less one: 0 1 2 3, then two an octave: [4, 5] [6, 7] [8, 11] [12, 15]
/// .. up to 2^31 - 1.
inline std::uint32_t bucket_of(std::uint32_t excess) {
    if (excess < 4) return excess;
    const auto octave = static_cast<std::uint32_t>(std::bit_width(excess)) - 1;
    return 2 * octave + (excess >> (octave - 1) & 1);
}

}  // namespace relief::codec
