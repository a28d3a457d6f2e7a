#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "codec/probability.h"

/// Adaptive probabilities of binary decisions and their mixing where streams are short: one
/// estimate a context, trained beforehand. docs/format.md, "Embedded streams".
namespace relief::codec {

/// The probability that a decision in one context is 1.
struct Chance {
    static constexpr std::uint32_t kLimit = 1023;

    std::uint32_t one = std::uint32_t{1} << 31;  ///< times 2^32
    std::uint32_t visits = 0;                    ///< up to kLimit

    void update(bool bit) {
        const std::int64_t error = (bit ? std::int64_t{0xffffffff} : 0) - std::int64_t{one};
        one = static_cast<std::uint32_t>(one + (error * kOdds.rate[visits] >> 16));
        if (visits < kLimit) ++visits;
    }
};

/// Learned weights of the odds of kSets contexts, times 65536.
template <int kSets>
struct Blend {
    std::array<std::int32_t, kSets> weights;
    std::int32_t visits = 0;

    Blend() { weights.fill(65536 / kSets); }

    [[nodiscard]] std::int64_t sum(const std::array<std::int32_t, kSets>& odds) const {
        std::int64_t total = 0;
        for (std::size_t k = 0; k < kSets; ++k) total += std::int64_t{weights[k]} * odds[k];
        return total;
    }

    /// error: 65536 times what the probability missed. Steps of odds * error / 2^14 at first,
    /// / 2^17 in the end.
    void update(const std::array<std::int32_t, kSets>& odds, std::int32_t error) {
        const int shift = visits < 128 ? 14 : visits < 1024 ? 15 : visits < 8192 ? 16 : 17;
        if (visits < 8192) ++visits;
        for (std::size_t k = 0; k < kSets; ++k) {
            const std::int32_t step = (odds[k] * error + (1 << (shift - 1))) >> shift;
            weights[k] = std::clamp(weights[k] + step, -kLargest, kLargest);
        }
    }

  private:
    static constexpr std::int32_t kLargest = 1 << 24;
};

/// Codes one decision under several contexts: two sets of weights, which learn each for itself,
/// add their odds, and the mean of the two sums is taken. All that took part learns.
template <int kSets, class Coder>
bool code_blended(Coder& coder, bool bit, const std::array<Chance*, kSets>& chances,
                  Blend<kSets>& first, Blend<kSets>& second) {
    const auto probability = [](std::int64_t sum) {
        const std::int64_t odds = std::clamp<std::int64_t>(sum >> 16, -kOddsLimit, kOddsLimit);
        return std::int32_t{kOdds.squash[static_cast<std::size_t>(odds + kOddsLimit)]};
    };
    std::array<std::int32_t, kSets> odds;
    for (std::size_t k = 0; k < kSets; ++k) odds[k] = kOdds.stretch[chances[k]->one >> 20];
    const std::int64_t sum_first = first.sum(odds);
    const std::int64_t sum_second = second.sum(odds);
    const std::int32_t mean = probability((sum_first + sum_second) >> 1);
    bit = coder.code(bit, codable(static_cast<std::uint32_t>(mean)));

    const std::int32_t target = bit ? 65535 : 0;
    first.update(odds, target - probability(sum_first));
    second.update(odds, target - probability(sum_second));
    for (Chance* chance : chances) chance->update(bit);
    return bit;
}

}  // namespace relief::codec
