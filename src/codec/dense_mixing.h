#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "codec/probability.h"

/// Adaptive probabilities of the dense profile: one estimate for each of three contexts, mixed and
/// refined. docs/format.md, "Profile dense".
namespace relief::codec::dense {

/// The probability that a decision in one context is 1, in 22 bits above the number of decisions
/// it has seen, in 10 bits.
class Estimate {
  public:
    static constexpr std::uint32_t kMostVisits = 1023;

    /// Of the probability, as kOdds.stretch is indexed.
    [[nodiscard]] std::uint32_t twelve_bits() const { return state_ >> 20; }

    void update(bool bit) {
        const std::uint32_t visits = state_ & kMostVisits;
        const std::int64_t error = (bit ? kOne - 1 : 0) - std::int64_t{state_ >> kVisitBits};
        const auto step = static_cast<std::int32_t>(error * kOdds.rate[visits] >> 16);
        state_ += static_cast<std::uint32_t>(step) << kVisitBits;
        state_ += visits < kMostVisits;
    }

    /// Makes what was learnt elsewhere worth `visits` decisions at most.
    void trust_at_most(std::uint32_t visits) {
        state_ = (state_ & ~kMostVisits) | std::min(state_ & kMostVisits, visits);
    }

  private:
    static constexpr std::uint32_t kVisitBits = 10;
    static constexpr std::int64_t kOne = std::int64_t{1} << (32 - kVisitBits);

    std::uint32_t state_ = std::uint32_t{1} << 31;
};

/// Weights of three log odds, times 2^14.
struct Mixer {
    static constexpr std::size_t kInputs = 3;
    static constexpr std::int32_t kOne = 1 << 14;

    std::array<std::int32_t, kInputs> weights;

    Mixer() { weights.fill(kOne * 36 / 100); }
};

/// Codes one decision under three contexts. All that took part learns.
template <class Coder>
bool code_mixed(Coder& coder, bool bit, Estimate& a, Estimate& b, Estimate& c, Mixer& mixer,
                Refinement& refinement) {
    const std::array<std::int32_t, Mixer::kInputs> odds = {kOdds.stretch[a.twelve_bits()],
                                                           kOdds.stretch[b.twelve_bits()],
                                                           kOdds.stretch[c.twelve_bits()]};
    std::int64_t sum = 0;  // hostile bytes may drive weights far
    for (std::size_t k = 0; k < Mixer::kInputs; ++k)
        sum += std::int64_t{mixer.weights[k]} * odds[k];
    const std::int64_t mixed = std::clamp<std::int64_t>(sum >> 14, -kOddsLimit, kOddsLimit);
    const auto position = static_cast<std::uint32_t>(mixed + kOddsLimit);
    const std::uint32_t predicted = kOdds.squash[position];

    constexpr std::uint32_t kStep = Refinement::kStep;
    const std::uint32_t cell = std::min(position / kStep, Refinement::kCells - 2);
    const std::uint32_t part = position - cell * kStep;
    std::uint16_t* around = &refinement.cells[cell];
    const std::uint32_t refined = (around[0] * (kStep - part) + around[1] * part) / kStep;

    bit = coder.code(bit, codable((predicted + refined) / 2));

    const std::int32_t target = bit ? 65535 : 0;
    const std::int32_t error = (target - static_cast<std::int32_t>(predicted)) >> 3;
    for (std::size_t k = 0; k < Mixer::kInputs; ++k)
        mixer.weights[k] += (odds[k] * error + 0x8000) >> 16;
    std::uint16_t& nearest = around[part >= kStep / 2];
    nearest = static_cast<std::uint16_t>(nearest + ((target - std::int32_t{nearest}) >> 6));
    a.update(bit);
    b.update(bit);
    c.update(bit);
    return bit;
}

}  // namespace relief::codec::dense
