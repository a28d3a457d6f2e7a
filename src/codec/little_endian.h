#pragma once

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

/// Reads a number and moves on. The caller has checked that its bytes are there.
template <class Unsigned>
Unsigned take(const std::uint8_t*& at) {
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < sizeof(Unsigned); ++k) value |= std::uint64_t{at[k]} << (8 * k);
    at += sizeof(Unsigned);
    return static_cast<Unsigned>(value);
}

inline double take_double(const std::uint8_t*& at) {
    const auto bits = take<std::uint64_t>(at);
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

}  // namespace relief::codec
