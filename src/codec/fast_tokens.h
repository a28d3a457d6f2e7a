#pragma once

#include <array>
#include <cstdint>

#include "codec/fast_bits.h"
#include "codec/fast_rows.h"
#include "codec/rans.h"

/// How often each token occurs in each class.
namespace relief::codec::fast {

/// How often a token occurred.
using TokenCounts = std::array<std::uint32_t, kTokens>;
using ClassCounts = std::array<TokenCounts, kClasses>;

/// Frequencies of a class, in a form that is cheap to send: quarters of an octave above the rarest
/// that can be told, 0 for tokens that do not occur.
using TokenWeights = std::array<std::uint8_t, kTokens>;

using TokenFrequencies = std::array<std::uint16_t, kTokens>;

/// Shares of kRansTotal in proportion to 2^(weight / 4); at least 1 for tokens that occur.
/// Requires: one does, weights are at most kLargestWeight.
TokenFrequencies frequencies_of(const TokenWeights& weights);
inline constexpr std::uint8_t kLargestWeight = 63;

/// The distributions of all classes, as encoder and decoder know them from one level to the next.
class TokenModel {
  public:
    TokenModel();  ///< those of typical terrain

    [[nodiscard]] TokenFrequencies frequencies(std::size_t c) const {
        return frequencies_of(weights_[c]);
    }

    /// Chooses, in bits of tokens and of their description together, between keeping each
    /// distribution, going back to the first and sending a new one; writes the choice. One bit:
    /// all go back; one bit: some are new; then a bit for each class, and for new ones, all as
    /// differences from the known ones: the last token that occurs and the weights up to it, in
    /// exponential Golomb codes of 0, -1, 1, -2, 2 ..
    void adapt(const ClassCounts& counts, BitWriter& bits);

    /// Reads what adapt() wrote. False: no encoder writes that.
    [[nodiscard]] bool read(BitReader& bits);

    friend bool operator==(const TokenModel&, const TokenModel&) = default;

  private:
    struct Plan;
    [[nodiscard]] Plan plan(const ClassCounts& counts) const;

    std::array<TokenWeights, kClasses> weights_;
};

/// Bits that the tokens cost, times 256.
std::uint64_t cost_of(const ClassCounts& counts, const TokenModel& model);

}  // namespace relief::codec::fast
