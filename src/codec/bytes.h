#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

/// Little-endian numbers in byte strings, the same on every machine.
namespace relief::codec {

class ByteWriter {
  public:
    void u8(std::uint8_t value) { bytes_.push_back(value); }
    void u16(std::uint16_t value) { integer(value, 2); }
    void u32(std::uint32_t value) { integer(value, 4); }
    void u64(std::uint64_t value) { integer(value, 8); }
    void i64(std::int64_t value) { u64(static_cast<std::uint64_t>(value)); }
    void f32(float value) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        u32(bits);
    }
    void f64(double value) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        u64(bits);
    }
    /// Seven bits a byte, lowest first; the top bit says that more follow.
    void varint(std::uint64_t value) {
        for (; value >= 0x80; value >>= 7) u8(static_cast<std::uint8_t>(value | 0x80));
        u8(static_cast<std::uint8_t>(value));
    }
    void bytes(std::span<const std::uint8_t> more) {
        bytes_.insert(bytes_.end(), more.begin(), more.end());
    }
    [[nodiscard]] std::size_t size() const { return bytes_.size(); }
    [[nodiscard]] std::vector<std::uint8_t> take() { return std::move(bytes_); }

  private:
    void integer(std::uint64_t value, int count) {
        for (int k = 0; k < count; ++k)
            bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
    }
    std::vector<std::uint8_t> bytes_;
};

/// Reads what ByteWriter wrote. Reading past the end gives zeros and sets failed().
class ByteReader {
  public:
    explicit ByteReader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

    std::uint8_t u8() { return static_cast<std::uint8_t>(integer(1)); }
    std::uint16_t u16() { return static_cast<std::uint16_t>(integer(2)); }
    std::uint32_t u32() { return static_cast<std::uint32_t>(integer(4)); }
    std::uint64_t u64() { return integer(8); }
    std::int64_t i64() { return static_cast<std::int64_t>(integer(8)); }
    float f32() {
        const std::uint32_t bits = u32();
        float value = 0;
        std::memcpy(&value, &bits, sizeof value);
        return value;
    }
    double f64() {
        const std::uint64_t bits = u64();
        double value = 0;
        std::memcpy(&value, &bits, sizeof value);
        return value;
    }
    /// At most 10 bytes; more, or more than 64 bits, fail.
    std::uint64_t varint() {
        std::uint64_t value = 0;
        for (int shift = 0; shift < 64; shift += 7) {
            const std::uint64_t byte = u8();
            if (shift == 63 && byte > 1) break;
            value |= (byte & 0x7f) << shift;
            if (byte < 0x80) return value;
        }
        failed_ = true;
        return 0;
    }
    /// The next `count` bytes; none and failed() when there are fewer.
    std::span<const std::uint8_t> take(std::uint64_t count) {
        if (rest_.size() < count) {
            failed_ = true;
            rest_ = {};
            return {};
        }
        const auto taken = rest_.first(static_cast<std::size_t>(count));
        rest_ = rest_.subspan(taken.size());
        return taken;
    }
    [[nodiscard]] bool failed() const { return failed_; }
    [[nodiscard]] std::span<const std::uint8_t> rest() const { return rest_; }

  private:
    std::uint64_t integer(std::size_t count) {
        if (rest_.size() < count) {
            failed_ = true;
            rest_ = {};
            return 0;
        }
        std::uint64_t value = 0;
        for (std::size_t k = 0; k < count; ++k)
            value |= static_cast<std::uint64_t>(rest_[k]) << (8 * k);
        rest_ = rest_.subspan(count);
        return value;
    }
    std::span<const std::uint8_t> rest_;
    bool failed_ = false;
};

}  // namespace relief::codec
