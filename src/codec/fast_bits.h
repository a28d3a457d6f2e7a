#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Raw bits, the lowest first, in little-endian bytes.
namespace relief::codec::fast {

class BitWriter {
  public:
    /// Requires: value < 2^count, count <= 32.
    void put(std::uint32_t value, int count) {
        waiting_ |= std::uint64_t{value} << count_;
        count_ += count;
        if (count_ >= 32) {
            for (int shift = 0; shift < 32; shift += 8)
                bytes_.push_back(static_cast<std::uint8_t>(waiting_ >> shift));
            waiting_ >>= 32;
            count_ -= 32;
        }
    }

    /// Whole bytes, zeros behind the last bit. The writer must not be used afterwards.
    std::vector<std::uint8_t> finish() {
        for (; count_ > 0; count_ -= 8, waiting_ >>= 8)
            bytes_.push_back(static_cast<std::uint8_t>(waiting_));
        return std::move(bytes_);
    }

  private:
    std::vector<std::uint8_t> bytes_;
    std::uint64_t waiting_ = 0;
    int count_ = 0;
};

/// Reads zeros behind the end.
class BitReader {
  public:
    explicit BitReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    /// Requires: count <= 32.
    std::uint32_t get(int count) {
        if (count_ < count) refill();
        const std::uint64_t value = waiting_ & ((std::uint64_t{1} << count) - 1);
        waiting_ >>= count;
        count_ -= count;
        return static_cast<std::uint32_t>(value);
    }

    /// No bit was missing, and less than a byte of zeros is left.
    [[nodiscard]] bool at_end() const {
        const std::uint64_t read =
            std::uint64_t{position_} * 8 - static_cast<std::uint64_t>(count_);
        return (read + 7) / 8 == bytes_.size() && waiting_ == 0;
    }

    /// The bytes behind the one that was begun.
    [[nodiscard]] std::span<const std::uint8_t> following_bytes() const {
        const std::size_t read = position_ - static_cast<std::size_t>(count_) / 8;
        return bytes_.subspan(std::min(read, bytes_.size()));
    }

  private:
    void refill() {
        std::uint64_t word = 0;
        for (std::size_t k = 0; k < 4; ++k)
            if (position_ + k < bytes_.size())
                word |= std::uint64_t{bytes_[position_ + k]} << (8 * k);
        position_ += 4;
        waiting_ |= word << count_;
        count_ += 32;
    }

    std::span<const std::uint8_t> bytes_;
    std::size_t position_ = 0;
    std::uint64_t waiting_ = 0;
    int count_ = 0;
};

}  // namespace relief::codec::fast
