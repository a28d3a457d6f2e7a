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

/// Weights, times 65536, of the odds that code_mixed adds: two for each set of contexts.
template <int kSets>
struct MixWeights {
    static constexpr std::size_t kInputs = 2 * kSets;
    static constexpr std::int32_t kStart =
        65536 * 11 / (10 * static_cast<int>(kInputs));  ///< they sum to 1.1

    std::array<std::int32_t, kInputs> weights;
    std::int32_t visits = 0;

    MixWeights() { weights.fill(kStart); }

    /// error: 65536 times what the probability missed. Steps of odds * error / 2^14 at first, /
    /// 2^17 in the end.
    void update(const std::array<std::int32_t, kInputs>& odds, std::int32_t error) {
        const int shift = visits < 128     ? 14
                          : visits < 1024  ? 15
                          : visits < 8192  ? 16
                          : visits < 65536 ? 17
                                           : 18;
        visits = std::min(visits + 1, 65536);
        for (std::size_t k = 0; k < kInputs; ++k) {
            const std::int32_t step = (odds[k] * error + (1 << (shift - 1))) >> shift;
            weights[k] = std::clamp(weights[k] + step, -kLargest, kLargest);
        }
    }

  private:
    static constexpr std::int32_t kLargest = 1 << 24;
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

/// Codes one decision under several contexts, whose slots are given: their odds are added with
/// learned weights, and the sum refined. All that took part learns.
template <int kSets, class Coder>
bool code_mixed(Coder& coder, bool bit, const std::array<Slot*, kSets>& slots,
                MixWeights<kSets>& mix, Refinement& refinement) {
    std::array<std::int32_t, 2 * kSets> odds;
    std::int64_t sum = 0;
    for (std::size_t k = 0; k < kSets; ++k) {
        odds[2 * k] = kOdds.stretch[slots[k]->slow >> 20];
        odds[2 * k + 1] = kOdds.stretch[slots[k]->fast >> 4];
        sum += std::int64_t{mix.weights[2 * k]} * odds[2 * k];
        sum += std::int64_t{mix.weights[2 * k + 1]} * odds[2 * k + 1];
    }
    const std::int64_t mixed = std::clamp<std::int64_t>(sum >> 16, -kOddsLimit, kOddsLimit);
    const auto position = static_cast<std::uint32_t>(mixed + kOddsLimit);
    const std::uint32_t predicted = kOdds.squash[position];

    constexpr std::uint32_t kStep = Refinement::kStep;
    const std::uint32_t cell = std::min(position / kStep, Refinement::kCells - 2);
    const std::uint32_t part = position - cell * kStep;
    std::uint16_t* around = &refinement.cells[cell];
    const std::uint32_t refined = (around[0] * (kStep - part) + around[1] * part) / kStep;

    bit = coder.code(bit, codable((predicted + refined) / 2));

    const std::int32_t target = bit ? 65535 : 0;
    mix.update(odds, target - static_cast<std::int32_t>(predicted));
    std::uint16_t& nearest = around[part >= kStep / 2];
    nearest = static_cast<std::uint16_t>(nearest + ((target - std::int32_t{nearest} + 32) >> 6));
    for (Slot* slot : slots) slot->update(bit);
    return bit;
}

template <int kSets, class Coder>
bool code_mixed2(Coder& coder, bool bit, const std::array<Slot*, kSets>& slots,
                 MixWeights<kSets>& mix, MixWeights<kSets>& mix2, Refinement& refinement) {
    std::array<std::int32_t, 2 * kSets> odds;
    std::int64_t sum = 0, sum2 = 0;
    for (std::size_t k = 0; k < kSets; ++k) {
        odds[2 * k] = kOdds.stretch[slots[k]->slow >> 20];
        odds[2 * k + 1] = kOdds.stretch[slots[k]->fast >> 4];
        sum += std::int64_t{mix.weights[2 * k]} * odds[2 * k];
        sum += std::int64_t{mix.weights[2 * k + 1]} * odds[2 * k + 1];
        sum2 += std::int64_t{mix2.weights[2 * k]} * odds[2 * k];
        sum2 += std::int64_t{mix2.weights[2 * k + 1]} * odds[2 * k + 1];
    }
    const std::int64_t mixed =
        std::clamp<std::int64_t>((sum + sum2) >> 17, -kOddsLimit, kOddsLimit);
    const auto position = static_cast<std::uint32_t>(mixed + kOddsLimit);
    const std::uint32_t predicted = kOdds.squash[position];

    constexpr std::uint32_t kStep = Refinement::kStep;
    const std::uint32_t cell = std::min(position / kStep, Refinement::kCells - 2);
    const std::uint32_t part = position - cell * kStep;
    std::uint16_t* around = &refinement.cells[cell];
    const std::uint32_t refined = (around[0] * (kStep - part) + around[1] * part) / kStep;

    bit = coder.code(bit, codable((predicted + refined) / 2));

    const std::int32_t target = bit ? 65535 : 0;
    const std::int64_t m1 =
        std::clamp<std::int64_t>(sum >> 16, -kOddsLimit, kOddsLimit) + kOddsLimit;
    const std::int64_t m2 =
        std::clamp<std::int64_t>(sum2 >> 16, -kOddsLimit, kOddsLimit) + kOddsLimit;
    mix.update(odds, target - static_cast<std::int32_t>(kOdds.squash[m1]));
    mix2.update(odds, target - static_cast<std::int32_t>(kOdds.squash[m2]));
    std::uint16_t& nearest = around[part >= kStep / 2];
    nearest = static_cast<std::uint16_t>(nearest + ((target - std::int32_t{nearest} + 32) >> 6));
    for (Slot* slot : slots) slot->update(bit);
    return bit;
}

}  // namespace relief::codec
