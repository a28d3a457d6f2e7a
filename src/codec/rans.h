#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "codec/little_endian.h"

/// Range asymmetric numeral systems with static frequencies: states of 32 bits, words of 16,
/// several states in rotation that share one stream of words. The encoder goes backwards and fills
/// the words from their end. Source: codec-closed-loop, section 7; J. Duda, "Asymmetric numeral
/// systems", arXiv:1311.2540.
namespace relief::codec {

inline constexpr int kRansBits = 12;  ///< frequencies of a distribution sum to 2^kRansBits
inline constexpr std::uint32_t kRansTotal = 1U << kRansBits;
inline constexpr std::uint32_t kRansLow = 1U << 16;  ///< states are at least this

/// One symbol for the encoder: its share start .. start + frequency - 1 of 0 .. kRansTotal - 1.
class RansSymbol {
  public:
    RansSymbol() = default;
    RansSymbol(std::uint32_t start, std::uint32_t frequency)
        : reciprocal_(((std::uint64_t{1} << kShift) + frequency - 1) / frequency),
          limit_(std::uint64_t{frequency} << (32 - kRansBits)),
          start_(static_cast<std::uint16_t>(start)),
          others_(static_cast<std::uint16_t>(kRansTotal - frequency)) {}

    /// Moves the symbol into `state`; a word that must leave it first is written below `end`.
    /// Returns the new end.
    std::uint16_t* encode(std::uint32_t& state, std::uint16_t* end) const {
        const bool full = state >= limit_;
        end[-1] = static_cast<std::uint16_t>(state);
        state >>= full ? 16 : 0;
        // floor(state / frequency), exactly: state < limit_ = 2^20 frequency, so that the
        // reciprocal's excess adds less than 1 / frequency, and the product is below 2^64.
        const auto quotient = static_cast<std::uint32_t>(state * reciprocal_ >> kShift);
        state += quotient * others_ + start_;
        return end - (full ? 1 : 0);
    }

  private:
    static constexpr int kShift = 44;

    std::uint64_t reciprocal_ = 0;  ///< 2^kShift / frequency, rounded up
    std::uint64_t limit_ = 0;
    std::uint16_t start_ = 0;
    std::uint16_t others_ = 0;  ///< kRansTotal less the frequency
};

/// One distribution for the decoder.
template <std::size_t kSymbols>
class RansTable {
  public:
    /// Requires: frequencies sum to kRansTotal.
    void set(const std::array<std::uint16_t, kSymbols>& frequencies) {
        std::uint32_t start = 0;
        for (std::size_t s = 0; s < kSymbols; ++s) {
            std::memset(&symbols_[start], static_cast<int>(s), frequencies[s]);
            shares_[s] = {static_cast<std::uint16_t>(start), frequencies[s]};
            start += frequencies[s];
        }
    }

    /// Takes a symbol out of `state`, which may then be below kRansLow.
    std::uint8_t decode(std::uint32_t& state) const {
        const std::uint32_t slot = state & (kRansTotal - 1);
        const std::uint8_t symbol = symbols_[slot];
        const Share share = shares_[symbol];
        state = share.frequency * (state >> kRansBits) + slot - share.start;
        return symbol;
    }

  private:
    struct Share {
        std::uint16_t start;
        std::uint16_t frequency;
    };
    std::array<std::uint8_t, kRansTotal> symbols_;
    std::array<Share, kSymbols> shares_;
};

/// Words of 16 bits, little-endian, read in order; zeros behind the end.
class RansWords {
  public:
    explicit RansWords(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    [[nodiscard]] bool has(std::size_t words) const {
        return bytes_.size() >= position_ + 2 * words;
    }
    [[nodiscard]] bool at_end() const { return bytes_.size() == position_; }

    std::uint16_t next() {
        const std::uint16_t word = has(1) ? load<std::uint16_t>(bytes_.data() + position_) : 0;
        position_ += 2;
        return word;
    }

    /// Refills the state if it is below kRansLow. kChecked = false requires: has(1).
    template <bool kChecked>
    void refill(std::uint32_t& state) {
        const bool low = state < kRansLow;
        std::uint32_t word = 0;
        if (!kChecked || has(1)) word = load<std::uint16_t>(bytes_.data() + position_);
        state = low ? state << 16 | word : state;
        position_ += low ? 2 : 0;
    }

  private:
    std::span<const std::uint8_t> bytes_;
    std::size_t position_ = 0;
};

}  // namespace relief::codec
