#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

/// Numbers as little-endian bytes, whatever the machine.
namespace relief::codec {

template <class Unsigned>
void put(std::vector<std::uint8_t>& out, Unsigned value) {
    for (std::size_t k = 0; k < sizeof(Unsigned); ++k)
        out.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

inline void put_double(std::vector<std::uint8_t>& out, double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    put(out, bits);
}

/// The number at any address. Copied at once where the machine allows: compilers do not merge the
/// bytes of the loop.
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

/// Reads a number and moves on. The caller has checked that its bytes are there.
template <class Unsigned>
Unsigned take(const std::uint8_t*& at) {
    const auto value = load<Unsigned>(at);
    at += sizeof(Unsigned);
    return value;
}

inline double take_double(const std::uint8_t*& at) {
    const auto bits = take<std::uint64_t>(at);
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

}  // namespace relief::codec
