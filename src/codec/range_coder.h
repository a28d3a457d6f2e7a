#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

/// Binary range coder: an interval [low, low + range) of 64-bit fractions is cut in proportion to
/// the probability of each decision. Probabilities have 16 bits; `one` is that of the decision
/// being 1, times 65536, in 1 .. 65535. Integer arithmetic only, so every machine decodes the same.
/// docs/format.md, "Range coder".
///
/// Encoder and decoder have the same members, so that one function template describes a format for
/// both: code(bit, one) returns the bit that was coded, which for the decoder does not depend on
/// its argument.
namespace relief::codec {

/// A moment of an encoder: the low end of its interval, as the number of bytes written and the 64
/// bits that follow them.
struct CodePoint {
    std::size_t written = 0;
    std::uint64_t low = 0;
};

class RangeEncoder {
  public:
    static constexpr bool kDecodes = false;

    bool code(bool bit, std::uint32_t one) {
        const std::uint64_t cut = (range_ >> 16) * one;
        if (bit) {
            range_ = cut;
        } else {
            advance(cut);
            range_ -= cut;
        }
        renormalise();
        return bit;
    }

    /// A value of `count` <= 16 bits, each with probability one half.
    std::uint32_t code_raw(std::uint32_t value, int count) {
        range_ >>= count;
        advance(range_ * value);
        renormalise();
        return value;
    }

    /// To be asked what it needs of the finished bytes: see bytes_up_to.
    [[nodiscard]] CodePoint point() const { return {bytes_.size(), low_}; }

    /// Writes the shortest byte string that decodes, the decoder reading zeros behind it, and
    /// returns all bytes. The encoder must not be used afterwards.
    std::vector<std::uint8_t> finish() {
        const std::uint64_t tail = std::bit_floor(range_) - 1;
        advance(tail);
        low_ &= ~tail;
        for (; low_ != 0; low_ <<= 8) bytes_.push_back(static_cast<std::uint8_t>(low_ >> 56));
        return std::move(bytes_);
    }

  private:
    void advance(std::uint64_t step) {
        low_ += step;
        if (low_ < step) carry();
    }

    /// Adds one to the number whose digits are the bytes written. Never runs off the front: low +
    /// range never exceeds the first interval.
    void carry() {
        std::size_t k = bytes_.size();
        while (++bytes_[--k] == 0) {
        }
    }

    void renormalise() {
        if (range_ >> 32 != 0) return;
        for (int shift = 56; shift >= 32; shift -= 8)
            bytes_.push_back(static_cast<std::uint8_t>(low_ >> shift));
        low_ <<= 32;
        range_ <<= 32;
    }

    std::uint64_t low_ = 0;
    std::uint64_t range_ = ~std::uint64_t{0};
    std::vector<std::uint8_t> bytes_;
};

/// The least number of leading bytes of a finished code from which a decoder, reading zeros behind
/// them, decodes all that was coded before `point`. The code value lies in the interval of that
/// moment, so cutting it must only not bring it below the interval's low end.
inline std::size_t bytes_up_to(std::span<const std::uint8_t> bytes, const CodePoint& point) {
    std::uint64_t window = 0;
    for (std::size_t k = point.written; k < point.written + 8; ++k)
        window = window << 8 | (k < bytes.size() ? bytes[k] : 0U);
    std::size_t needed = point.written;
    // A window below means that a carry has since raised the bytes before it: they suffice alone.
    if (window >= point.low)
        for (std::uint64_t cut = ~std::uint64_t{0}; (window & ~cut) < point.low; cut >>= 8)
            ++needed;
    return std::min(needed, bytes.size());
}

class RangeDecoder {
  public:
    static constexpr bool kDecodes = true;

    explicit RangeDecoder(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
        offset_ = std::uint64_t{next_word()} << 32;
        offset_ |= next_word();
    }

    bool code(bool, std::uint32_t one) {
        const std::uint64_t cut = (range_ >> 16) * one;
        const bool bit = offset_ < cut;
        offset_ -= bit ? 0 : cut;  // selected, not branched to: bits are hard to foresee
        range_ = bit ? cut : range_ - cut;
        renormalise();
        return bit;
    }

    std::uint32_t code_raw(std::uint32_t, int count) {
        range_ >>= count;
        std::uint64_t value = offset_ / range_;
        const std::uint64_t largest = (std::uint64_t{1} << count) - 1;
        if (value > largest) value = largest;  // an altered stream may point past the last interval
        offset_ -= value * range_;
        renormalise();
        return static_cast<std::uint32_t>(value);
    }

    /// More bytes were needed than there are: the stream is cut off.
    [[nodiscard]] bool ran_out() const { return consumed_ > bytes_.size() + 8; }

    /// The stream ends where the decisions end: no byte was missing and none is left.
    [[nodiscard]] bool at_end() const { return !ran_out() && consumed_ >= bytes_.size() + 4; }

  private:
    void renormalise() {
        if (range_ >> 32 != 0) return;
        offset_ = offset_ << 32 | next_word();
        range_ <<= 32;
    }

    std::uint32_t next_word() {
        std::uint32_t word = 0;
        for (int k = 0; k < 4; ++k) {
            word = word << 8 | (consumed_ < bytes_.size() ? bytes_[consumed_] : 0U);
            ++consumed_;
        }
        return word;
    }

    std::span<const std::uint8_t> bytes_;
    std::size_t consumed_ = 0;
    std::uint64_t offset_ = 0;  ///< of the code value from the encoder's low
    std::uint64_t range_ = ~std::uint64_t{0};
};

/// An encoder that remembers its decisions, to compare them with what its bytes decode to.
class CheckedEncoder {
  public:
    static constexpr bool kDecodes = false;

    bool code(bool bit, std::uint32_t one) {
        decisions_.push_back({static_cast<std::uint16_t>(one), 0, bit});
        return encoder_.code(bit, one);
    }
    std::uint32_t code_raw(std::uint32_t value, int count) {
        decisions_.push_back(
            {static_cast<std::uint16_t>(value), static_cast<std::uint8_t>(count), false});
        return encoder_.code_raw(value, count);
    }

    std::vector<std::uint8_t> finish() { return encoder_.finish(); }

    /// Whether a decoder that asks the same questions gets the same answers.
    [[nodiscard]] bool decodes_from(std::span<const std::uint8_t> bytes) const {
        RangeDecoder decoder(bytes);
        bool same = true;
        for (const Decision& decision : decisions_)
            same &= decision.count == 0 ? decoder.code(false, decision.number) == decision.bit
                                        : decoder.code_raw(0, decision.count) == decision.number;
        return same && decoder.at_end();
    }

  private:
    struct Decision {
        std::uint16_t number;  ///< the probability, or the value of raw bits
        std::uint8_t count;    ///< of raw bits; 0: one decision
        bool bit;
    };

    RangeEncoder encoder_;
    std::vector<Decision> decisions_;
};

/// Adds up what the decisions would cost.
class CostCounter {
  public:
    static constexpr bool kDecodes = false;

    bool code(bool bit, std::uint32_t one) {
        bits_ -= std::log2(static_cast<double>(bit ? one : 65536 - one) / 65536);
        return bit;
    }
    std::uint32_t code_raw(std::uint32_t value, int count) {
        bits_ += count;
        return value;
    }
    [[nodiscard]] double bits() const { return bits_; }

  private:
    double bits_ = 0;
};

/// The lowest `count` bits as they are, sixteen at most in one step.
template <class Coder>
std::uint32_t code_low_bits(Coder& coder, std::uint32_t value, int count) {
    std::uint32_t high = 0;
    if (count > 16) {
        high = coder.code_raw(value >> 16 & ((1U << (count - 16)) - 1), count - 16) << 16;
        count = 16;
    }
    return count == 0 ? 0 : high | coder.code_raw(value & ((1U << count) - 1), count);
}

}  // namespace relief::codec
