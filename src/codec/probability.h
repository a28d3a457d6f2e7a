#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

/// Adaptive probabilities of binary decisions and their mixing, in integers. docs/format.md, "Probabilities".
namespace relief::codec {

/// Log odds ln(p / (1 - p)) are integers in units of 1/256, within +-kOddsLimit.
inline constexpr std::int32_t kOddsLimit = 3072;

struct OddsTables {
    std::array<std::uint16_t, 2 * kOddsLimit + 1> squash;  ///< by odds + kOddsLimit: probability times 65536
    std::array<std::int16_t, 4096> stretch;                ///< by probability times 4096: odds
    std::array<std::uint16_t, 256> rate;                   ///< by visits n: 65536 / (n + 1.6), at most 32767
};
extern const OddsTables kOdds;

/// Probability that a decision in one context is 1, estimated at two speeds.
struct Slot {
    static constexpr std::uint16_t kSlowLimit = 255;
    static constexpr std::uint16_t kFastLimit = 30;

    std::uint32_t slow = std::uint32_t{1} << 31;  ///< times 2^32
    std::uint16_t fast = std::uint16_t{1} << 15;  ///< times 2^16
    std::uint16_t visits = 0;                     ///< up to kSlowLimit

    [[nodiscard]] std::int32_t slow_odds() const { return kOdds.stretch[slow >> 20]; }
    [[nodiscard]] std::int32_t fast_odds() const { return kOdds.stretch[fast >> 4]; }

    void update(bool bit) {
        const std::int64_t slow_error = (bit ? std::int64_t{0xffffffff} : 0) - std::int64_t{slow};
        const std::int32_t fast_error = (bit ? 0xffff : 0) - std::int32_t{fast};
        slow = static_cast<std::uint32_t>(slow + (slow_error * kOdds.rate[visits] >> 16));
        fast = static_cast<std::uint16_t>(fast + (fast_error * kOdds.rate[std::min(visits, kFastLimit)] >> 16));
        if (visits < kSlowLimit) ++visits;
    }
};

/// Weights, times 2^16, of the odds that a Mixer adds.
template <int kSets>
struct MixWeights {
    static constexpr int kInputs = 2 * kSets;
    static constexpr std::int32_t kStart = 65536 * 11 / (10 * kInputs);  ///< they sum to 1.1

    std::array<std::int32_t, kInputs> weights;
    std::int32_t visits = 0;
    MixWeights() { weights.fill(kStart); }
};

/// A probability refined by what happened when it was predicted: 49 cells along the odds, interpolated.
struct Refinement {
    static constexpr int kStep = 128;
    static constexpr int kCells = 2 * kOddsLimit / kStep + 1;

    std::array<std::uint16_t, kCells> cells;
    Refinement() {
        for (int k = 0; k < kCells; ++k) cells[static_cast<std::size_t>(k)] = kOdds.squash[static_cast<std::size_t>(k * kStep)];
    }
};

/// Codes one decision under the contexts whose slots are given; all of them learn from it.
template <int kSets, class Coder>
bool code_mixed(Coder& coder, bool bit, const std::array<Slot*, kSets>& slots, MixWeights<kSets>& mix,
                Refinement& refinement) {
    std::array<std::int32_t, 2 * kSets> odds;
    for (std::size_t k = 0; k < kSets; ++k) {
        odds[2 * k] = slots[k]->slow_odds();
        odds[2 * k + 1] = slots[k]->fast_odds();
    }
    std::int64_t sum = 0;
    for (std::size_t k = 0; k < 2 * kSets; ++k) sum += std::int64_t{mix.weights[k]} * odds[k];
    const auto mixed = static_cast<std::int32_t>(std::clamp<std::int64_t>(sum >> 16, -kOddsLimit, kOddsLimit));

    const auto position = static_cast<std::uint32_t>(mixed + kOddsLimit);
    const std::uint32_t cell = std::min<std::uint32_t>(position / Refinement::kStep, Refinement::kCells - 2);
    const std::uint32_t part = position - cell * Refinement::kStep;
    std::uint16_t* around = &refinement.cells[cell];
    const std::uint32_t refined = (around[0] * (Refinement::kStep - part) + around[1] * part) / Refinement::kStep;
    const std::uint32_t predicted = kOdds.squash[position];
    bit = coder.code(bit, std::clamp<std::uint32_t>((predicted + refined) / 2, 16, 65520));

    const std::int32_t target = bit ? 65535 : 0;
    const int shift = mix.visits < 128 ? 14 : mix.visits < 1024 ? 15 : mix.visits < 8192 ? 16 : 17;
    ++mix.visits;
    const std::int32_t error = target - static_cast<std::int32_t>(predicted);
    for (std::size_t k = 0; k < 2 * kSets; ++k) {
        const std::int32_t step = (odds[k] * error + (1 << (shift - 1))) >> shift;
        mix.weights[k] += step;
    }
    std::uint16_t& nearest = around[part >= Refinement::kStep / 2];
    nearest = static_cast<std::uint16_t>(nearest + ((target - std::int32_t{nearest}) >> 6));
    for (Slot* slot : slots) slot->update(bit);
    return bit;
}

}  // namespace relief::codec
