#include "codec/fast_tokens.h"

#include <algorithm>
#include <bit>

#include "codec/fast_terrain.h"

namespace relief::codec::fast {

namespace {

constexpr int kTopWeight = 49;  ///< of the commonest token; 1 is then 12 octaves below
constexpr std::uint64_t kNever = std::uint64_t{1} << 56;  ///< the cost of what can not be coded

/// 256 log2(x), rounded down, by squaring. Requires: x > 0.
constexpr std::uint32_t log2_256(std::uint32_t x) {
    const int whole = std::bit_width(x) - 1;
    std::uint64_t mantissa = std::uint64_t{x} << (31 - whole);
    auto log = static_cast<std::uint32_t>(whole);
    for (int k = 0; k < 8; ++k) {
        mantissa = mantissa * mantissa >> 31;
        const bool carry = mantissa >> 32 != 0;
        mantissa >>= carry ? 1 : 0;
        log = 2 * log + (carry ? 1 : 0);
    }
    return log;
}

/// Costs of 1 / kRansTotal .. 1, in 1 / 256 bits.
const std::array<std::uint16_t, kRansTotal + 1>& costs() {
    static const auto table = [] {
        std::array<std::uint16_t, kRansTotal + 1> cost{};
        for (std::uint32_t f = 1; f <= kRansTotal; ++f)
            cost[f] = static_cast<std::uint16_t>(256 * kRansBits - log2_256(f));
        return cost;
    }();
    return table;
}

std::uint64_t cost_of(const TokenCounts& counts, const TokenWeights& weights) {
    const auto frequencies = frequencies_of(weights);
    std::uint64_t sum = 0;
    for (std::size_t t = 0; t < kTokens; ++t) {
        if (counts[t] == 0) continue;
        if (frequencies[t] == 0) return kNever;
        sum += std::uint64_t{counts[t]} * costs()[frequencies[t]];
    }
    return sum;
}

/// Requires: a token occurred.
TokenWeights weights_of(const TokenCounts& counts) {
    const std::uint32_t top = log2_256(*std::max_element(counts.begin(), counts.end()));
    TokenWeights weights{};
    for (std::size_t t = 0; t < kTokens; ++t) {
        if (counts[t] == 0) continue;
        const auto below = static_cast<int>((top - log2_256(counts[t]) + 32) / 64);
        weights[t] = static_cast<std::uint8_t>(std::max(kTopWeight - below, 1));
    }
    return weights;
}

std::size_t last_token(const TokenWeights& weights) {
    std::size_t t = kTokens - 1;
    while (t > 0 && weights[t] == 0) --t;
    return t;
}

std::uint32_t folded(int v) {
    return static_cast<std::uint32_t>(v < 0 ? -2 * v - 1 : 2 * v);
}

int unfolded(std::uint32_t v) {
    return v % 2 ? -static_cast<int>(v / 2) - 1 : static_cast<int>(v / 2);
}

int golomb_bits(std::uint32_t v) {
    return 2 * std::bit_width(v + 1) - 1;
}

/// Exponential Golomb code: the width of v + 1 in unary, then v + 1 without its top bit.
void put_golomb(BitWriter& bits, std::uint32_t v) {
    const int width = std::bit_width(v + 1) - 1;
    bits.put(1U << width, width + 1);
    bits.put(v + 1 - (1U << width), width);
}

/// Numbers of up to 8 bits; more than any encoder writes for others.
std::uint32_t get_golomb(BitReader& bits) {
    int width = 0;
    while (width < 8 && bits.get(1) == 0) ++width;
    return (1U << width) + bits.get(width) - 1;
}

/// Calls put(v) for the numbers that describe `to` when `from` is known.
template <class Put>
void describe(const TokenWeights& from, const TokenWeights& to, Put put) {
    const std::size_t last = last_token(to);
    put(folded(static_cast<int>(last) - static_cast<int>(last_token(from))));
    for (std::size_t t = 0; t <= last; ++t) put(folded(int{to[t]} - int{from[t]}));
}

bool read_weights(BitReader& bits, TokenWeights& weights) {
    const int last = static_cast<int>(last_token(weights)) + unfolded(get_golomb(bits));
    if (last < 0 || last >= kTokens) return false;
    bool any = false;
    for (int t = 0; t < kTokens; ++t) {
        std::uint8_t& weight = weights[static_cast<std::size_t>(t)];
        const int sent = t > last ? 0 : int{weight} + unfolded(get_golomb(bits));
        if (sent < 0 || sent > kLargestWeight) return false;
        weight = static_cast<std::uint8_t>(sent);
        any |= sent > 0;
    }
    return any;
}

}  // namespace

TokenFrequencies frequencies_of(const TokenWeights& weights) {
    constexpr std::array<std::uint32_t, 4> quarter = {256, 304, 362, 431};  // 2^(8 + k / 4)
    std::array<std::uint64_t, kTokens> parts{};
    std::uint64_t sum = 0;
    for (std::size_t t = 0; t < kTokens; ++t) {
        if (weights[t] == 0) continue;
        parts[t] = std::uint64_t{quarter[weights[t] % 4]} << (weights[t] / 4);
        sum += parts[t];
    }
    TokenFrequencies frequencies{};
    std::uint32_t rest = kRansTotal;
    for (std::size_t t = 0; t < kTokens; ++t) {
        if (weights[t] == 0) continue;
        frequencies[t] =
            static_cast<std::uint16_t>(std::max<std::uint64_t>(parts[t] * kRansTotal / sum, 1));
        rest -= frequencies[t];
    }
    // The commonest has at least 1 / 32 of all: it can pay for the minima of the others.
    auto& most = *std::max_element(frequencies.begin(), frequencies.end());
    most = static_cast<std::uint16_t>(most + rest);
    return frequencies;
}

/// What to do with each class, from one set of distributions.
struct TokenModel::Plan {
    std::array<TokenWeights, kClasses> weights;
    std::array<bool, kClasses> sent{};
    std::uint64_t cost = 0;
};

TokenModel::TokenModel() : weights_(kTerrain) {}

TokenModel::Plan TokenModel::plan(const ClassCounts& counts) const {
    Plan plan{weights_};
    for (std::size_t c = 0; c < kClasses; ++c) {
        const bool occurs = std::any_of(counts[c].begin(), counts[c].end(),
                                        [](std::uint32_t count) { return count > 0; });
        if (!occurs) continue;
        const std::uint64_t kept = cost_of(counts[c], weights_[c]);
        const TokenWeights fitted = weights_of(counts[c]);
        int bits = 0;
        describe(weights_[c], fitted, [&](std::uint32_t v) { bits += golomb_bits(v); });
        const std::uint64_t renewed =
            cost_of(counts[c], fitted) + 256 * static_cast<std::uint64_t>(bits);
        plan.sent[c] = renewed < kept;
        if (plan.sent[c]) plan.weights[c] = fitted;
        plan.cost += std::min(kept, renewed);
    }
    return plan;
}

void TokenModel::adapt(const ClassCounts& counts, BitWriter& bits) {
    const Plan here = plan(counts);
    const Plan anew = TokenModel().plan(counts);
    const bool restart = anew.cost < here.cost;
    const Plan& best = restart ? anew : here;
    if (restart) weights_ = kTerrain;
    const bool any = std::find(best.sent.begin(), best.sent.end(), true) != best.sent.end();
    bits.reserve(kClasses * (2 * kTokens * 16));
    bits.put(restart, 1);
    bits.put(any, 1);
    for (std::size_t c = 0; any && c < kClasses; ++c) {
        bits.put(best.sent[c], 1);
        if (best.sent[c])
            describe(weights_[c], best.weights[c], [&](std::uint32_t v) { put_golomb(bits, v); });
    }
    weights_ = best.weights;
}

bool TokenModel::read(BitReader& bits) {
    if (bits.get(1) != 0) weights_ = kTerrain;
    if (bits.get(1) == 0) return true;
    for (TokenWeights& weights : weights_)
        if (bits.get(1) != 0 && !read_weights(bits, weights)) return false;
    return true;
}

std::uint64_t cost_of(const ClassCounts& counts, const TokenModel& model) {
    std::uint64_t sum = 0;
    for (std::size_t c = 0; c < kClasses; ++c) {
        const TokenFrequencies frequencies = model.frequencies(c);
        for (std::size_t t = 0; t < kTokens; ++t)
            sum += std::uint64_t{counts[c][t]} * costs()[frequencies[t]];
    }
    return sum;
}

}  // namespace relief::codec::fast
