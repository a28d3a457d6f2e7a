#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/little_endian.h"

/// Raw bits, the lowest first, in little-endian bytes.
namespace relief::codec::fast {

class BitWriter {
  public:
    /// Room for `count` more bits: put() does not look.
    void reserve(std::size_t count) {
        const std::size_t needed = size_ + count / 8 + 2 * sizeof(std::uint64_t);
        if (bytes_.size() < needed) bytes_.resize(std::max(needed, 2 * bytes_.size()));
    }

    /// Requires: value < 2^count, count <= 32, room.
    void put(std::uint32_t value, int count) {
        waiting_ |= std::uint64_t{value} << count_;
        count_ += count;
        store(waiting_, bytes_.data() + size_);
        const int whole = count_ / 8;
        size_ += static_cast<std::size_t>(whole);
        waiting_ >>= 8 * whole;
        count_ -= 8 * whole;
    }

    /// Whole bytes, zeros behind the last bit.
    [[nodiscard]] std::span<const std::uint8_t> bytes() const {
        return std::span(bytes_).first(size_ + (count_ > 0 ? 1 : 0));
    }

  private:
    std::vector<std::uint8_t> bytes_;
    std::size_t size_ = 0;  ///< whole bytes written
    std::uint64_t waiting_ = 0;
    int count_ = 0;  ///< of waiting bits, below 8
};

/// Reads zeros behind the end.
class BitReader {
  public:
    explicit BitReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    /// Requires: count <= 32.
    std::uint32_t get(int count) {
        const std::size_t byte = position_ / 8;
        const std::uint64_t word =
            byte + 8 <= bytes_.size() ? load<std::uint64_t>(bytes_.data() + byte) : load_last(byte);
        const std::uint64_t mask = (std::uint64_t{1} << count) - 1;
        const std::uint64_t value = word >> (position_ % 8) & mask;
        position_ += static_cast<std::size_t>(count);
        return static_cast<std::uint32_t>(value);
    }

    /// The bytes behind the last one begun.
    [[nodiscard]] std::span<const std::uint8_t> rest() const {
        return bytes_.subspan(std::min((position_ + 7) / 8, bytes_.size()));
    }

    /// No bit was missing, and less than a byte of zeros is left.
    [[nodiscard]] bool at_end() const {
        if ((position_ + 7) / 8 != bytes_.size()) return false;
        return position_ % 8 == 0 || bytes_.back() >> (position_ % 8) == 0;
    }

  private:
    [[nodiscard]] std::uint64_t load_last(std::size_t byte) const {
        std::uint64_t word = 0;
        for (std::size_t k = 0; byte + k < bytes_.size(); ++k)
            word |= std::uint64_t{bytes_[byte + k]} << (8 * k);
        return word;
    }

    std::span<const std::uint8_t> bytes_;
    std::size_t position_ = 0;  ///< in bits
};

}  // namespace relief::codec::fast
