#pragma once

#include <cstdint>

namespace relief::codec {

/// |q|, also of the least int32.
inline std::uint32_t magnitude_of(std::int32_t q) {
    const auto bits = static_cast<std::uint32_t>(q);
    return q < 0 ? 0U - bits : bits;
}

}  // namespace relief::codec
