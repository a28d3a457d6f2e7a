#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

/// Adaptive probabilities of binary decisions and their mixing, in integers. docs/format.md,
/// "Probabilities".
namespace relief::codec {

/// Log odds ln(p / (1 - p)) are integers in units of 1/256, within +-kOddsLimit.
inline constexpr std::int32_t kOddsLimit = 3072;

struct OddsTables {
    std::array<std::uint16_t, 2 * kOddsLimit + 1>
        squash;                              ///< of odds + kOddsLimit: the probability times 65536
    std::array<std::int16_t, 4096> stretch;  ///< of the probability times 4096: the odds
    std::array<std::uint16_t, 1024> rate;    ///< of visits n: 65536 / (n + 1.6), at most 32767
};
extern const OddsTables kOdds;

/// Probabilities given to the range coder: one decision costs at least 0.0004 and at most 12 bits.
inline std::uint32_t codable(std::uint32_t one) {
    return std::clamp<std::uint32_t>(one, 16, 65520);
}

/// The probability that a decision in one context is 1, estimated at two speeds.
struct Slot {
    static constexpr std::uint16_t kSlowLimit = 1023;
    static constexpr std::uint16_t kFastLimit = 30;

    std::uint32_t slow = std::uint32_t{1} << 31;  ///< times 2^32
    std::uint16_t fast = std::uint16_t{1} << 15;  ///< times 2^16
    std::uint16_t visits = 0;                     ///< up to kSlowLimit

    Slot() = default;
    /// p is a probability times 2^32, trusted as if it came from `seen` visits.
    Slot(std::uint64_t p, std::uint16_t seen)
        : slow(static_cast<std::uint32_t>(p)),
          fast(static_cast<std::uint16_t>(p >> 16)),
          visits(seen) {}

    void update(bool bit) {
        const std::int64_t slow_error = (bit ? std::int64_t{0xffffffff} : 0) - std::int64_t{slow};
        const std::int32_t fast_error = (bit ? 0xffff : 0) - std::int32_t{fast};
        slow = static_cast<std::uint32_t>(slow + (slow_error * kOdds.rate[visits] >> 16));
        fast = static_cast<std::uint16_t>(
            fast + (fast_error * kOdds.rate[std::min(visits, kFastLimit)] >> 16));
        if (visits < kSlowLimit) ++visits;
    }
};

/// A probability corrected by what happened when it was predicted: cells along the odds,
/// interpolated.
struct Refinement {
    static constexpr std::uint32_t kStep = 128;
    static constexpr std::uint32_t kCells = 2 * kOddsLimit / kStep + 1;

    std::array<std::uint16_t, kCells> cells;

    Refinement() {
        for (std::uint32_t k = 0; k < kCells; ++k) cells[k] = kOdds.squash[k * kStep];
    }
};

/// Codes one decision under one context.
template <class Coder>
bool code_adaptive(Coder& coder, bool bit, Slot& slot) {
    bit = coder.code(bit, codable(((slot.slow >> 16) + slot.fast) / 2));
    slot.update(bit);
    return bit;
}

}  // namespace relief::codec
