#pragma once

#include <hwy/base.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "codec/probability.h"

/// Adaptive probabilities of the dense profile: one estimate for each of three contexts, mixed and
/// refined. Source: codec-closed-loop, section 4.7; one rate of learning instead of two, because
/// estimates start anew at each level.
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

/// Three estimates of one decision, added as log odds with learnt weights.
class Mixer {
  public:
    using Estimates = std::array<Estimate*, 3>;
    using Odds = std::array<std::int32_t, 3>;

    static Odds odds_of(const Estimates& estimates) {
        return {kOdds.stretch[estimates[0]->twelve_bits()],
                kOdds.stretch[estimates[1]->twelve_bits()],
                kOdds.stretch[estimates[2]->twelve_bits()]};
    }

    /// The sum, plus kOddsLimit: an index of kOdds.squash.
    [[nodiscard]] std::uint32_t mix(const Odds& odds) const {
        std::int32_t sum = 0;
        for (std::size_t k = 0; k < odds.size(); ++k) sum += weights_[k] * odds[k];
        return static_cast<std::uint32_t>(std::clamp(sum >> 14, -kOddsLimit, kOddsLimit) +
                                          kOddsLimit);
    }

    /// `miss`: 65536 times what the probability was too low.
    void learn(const Odds& odds, std::int32_t miss) {
        for (std::size_t k = 0; k < odds.size(); ++k)
            weights_[k] = std::clamp(weights_[k] + ((odds[k] * (miss >> 2) + (1 << 15)) >> 16),
                                     -kLargest, kLargest);
    }

  private:
    static constexpr std::int32_t kStart = (1 << 14) * 36 / 100;
    static constexpr std::int32_t kLargest = 1 << 17;  ///< three products fit 32 bits

    std::array<std::int32_t, 3> weights_ = {kStart, kStart, kStart};  ///< times 2^14
};

/// 65535 or 0: what a probability of the decision should have been.
inline std::int32_t target_of(bool bit) {
    return bit ? 65535 : 0;
}

/// Codes one decision under three contexts. All that took part learns.
template <class Coder>
HWY_INLINE bool code_mixed(Coder& coder, bool bit, const Mixer::Estimates& estimates,
                           Mixer& mixer) {
    const Mixer::Odds odds = Mixer::odds_of(estimates);
    const std::uint32_t predicted = kOdds.squash[mixer.mix(odds)];
    bit = coder.code(bit, codable(predicted));
    mixer.learn(odds, target_of(bit) - static_cast<std::int32_t>(predicted));
    for (Estimate* estimate : estimates) estimate->update(bit);
    return bit;
}

/// The same with the probability refined by what happened when it was predicted.
template <class Coder>
HWY_INLINE bool code_refined(Coder& coder, bool bit, const Mixer::Estimates& estimates,
                             Mixer& mixer, Refinement& refinement) {
    const Mixer::Odds odds = Mixer::odds_of(estimates);
    const std::uint32_t position = mixer.mix(odds);
    const std::uint32_t predicted = kOdds.squash[position];
    constexpr std::uint32_t kStep = Refinement::kStep;
    const std::uint32_t cell = std::min(position / kStep, Refinement::kCells - 2);
    const std::uint32_t part = position - cell * kStep;
    std::uint16_t* const around = &refinement.cells[cell];
    const std::uint32_t refined = (around[0] * (kStep - part) + around[1] * part) / kStep;

    bit = coder.code(bit, codable((predicted + refined) / 2));

    mixer.learn(odds, target_of(bit) - static_cast<std::int32_t>(predicted));
    std::uint16_t& nearest = around[part >= kStep / 2];
    nearest = static_cast<std::uint16_t>(nearest + ((target_of(bit) - std::int32_t{nearest}) >> 6));
    for (Estimate* estimate : estimates) estimate->update(bit);
    return bit;
}

}  // namespace relief::codec::dense
