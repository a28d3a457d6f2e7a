#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

/// Little-endian numbers at known addresses, for loops that count every instruction; bytes.h has
/// the checked readers and writers.
namespace relief::codec {

/// Copied at once where the machine allows: compilers do not merge the bytes of the loop.
template <class Unsigned>
Unsigned load(const std::uint8_t* at) {
    Unsigned value = 0;
    if constexpr (std::endian::native == std::endian::little) {
        std::memcpy(&value, at, sizeof value);
    } else {
        for (std::size_t k = sizeof value; k-- > 0;)
            value = static_cast<Unsigned>(value << 8 | at[k]);
    }
    return value;
}

template <class Unsigned>
void store(Unsigned value, std::uint8_t* at) {
    if constexpr (std::endian::native == std::endian::little) {
        std::memcpy(at, &value, sizeof value);
    } else {
        for (std::size_t k = 0; k < sizeof value; ++k)
            at[k] = static_cast<std::uint8_t>(value >> (8 * k));
    }
}

}  // namespace relief::codec
