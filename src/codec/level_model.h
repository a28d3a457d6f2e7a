#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "codec/probability.h"

namespace relief::codec {

/// Quantises v logarithmically: 0 .. 7, then four classes an octave, at most `last`.
inline std::uint32_t log_class(std::uint32_t v, std::uint32_t last) {
    if (v < 8) return std::min(v, last);
    const auto octave = static_cast<std::uint32_t>(std::bit_width(v)) - 3;
    return std::min(4 * octave + (v >> octave), last);
}

/// The least v of a class of log_class.
inline std::uint32_t log_class_floor(std::uint32_t c) {
    return c < 8 ? c : (4 + c % 4) << (c / 4 - 1);
}

/// The bucket of a magnitude less one: 0 1 2 3, then two an octave: [4, 5] [6, 7] [8, 11] [12, 15]
/// .. up to 2^31 - 1.
inline std::uint32_t bucket_of(std::uint32_t excess) {
    if (excess < 4) return excess;
    const auto octave = static_cast<std::uint32_t>(std::bit_width(excess)) - 1;
    return 2 * octave + (excess >> (octave - 1) & 1);
}

/// What is known of a coefficient before it is coded, as numbers of contexts.
struct Surroundings {
    std::uint32_t expected;  ///< class of the expected magnitude, under LevelModel::kExpected
    std::uint32_t sources;   ///< classes of what neighbours say and of what parent and siblings say
    std::uint32_t
        pattern;  ///< W, N, NW, NE, each 0, 1 or more, and the class of parent and siblings
    std::uint32_t nearest;       ///< W and N, six classes each
    std::uint32_t signs_ring;    ///< signs of W, N, NW, NE
    std::uint32_t signs_cross;   ///< signs of W, N, WW, NN
    std::uint32_t signs_strong;  ///< signs of W and N, and whether they exceed 1
};

/// Everything that the coder of one level learns. docs/format.md lists the same tables.
struct LevelModel {
    static constexpr std::uint32_t kBands = 8;  ///< later bands share the statistics of the eighth
    static constexpr std::uint32_t kKinds = 2;  ///< details, prediction residuals
    static constexpr std::uint32_t kExpected = 64;
    static constexpr std::uint32_t kNeighbours = 16;
    static constexpr std::uint32_t kAcross = 12;
    static constexpr std::uint32_t kSources = kNeighbours * kAcross;
    static constexpr std::uint32_t kPatterns = 81 * 4;
    static constexpr std::uint32_t kNearest = 6 * 6;
    static constexpr std::uint32_t kBuckets = 61;  ///< decisions "the bucket is beyond u"
    static constexpr std::uint32_t kLowBuckets =
        16;  ///< the first of them, and one context for all others
    static constexpr std::uint32_t kUnitExpected =
        75;  ///< the sum of weights that expects magnitude 1

    std::array<std::array<std::array<Slot, 16>, 4>, kBands>
        block;  ///< [band][neighbour flags][activity]

    std::array<std::array<Slot, kExpected>, kBands> zero_expected;
    std::array<std::array<Slot, kSources>, kKinds> zero_sources;
    std::array<std::array<Slot, kPatterns>, kKinds> zero_pattern;
    MixWeights<3> zero_mix;
    std::array<Refinement, kExpected> zero_refinement;

    std::array<std::array<Slot, 81>, kBands> sign_ring;
    std::array<std::array<Slot, 81>, kBands> sign_cross;
    std::array<std::array<Slot, 25>, kBands> sign_strong;
    MixWeights<3> sign_mix;
    Refinement sign_refinement;

    std::array<std::array<std::array<Slot, kExpected>, kBuckets>, kKinds> bucket_expected;
    std::array<std::array<std::array<Slot, kSources>, kLowBuckets>, kKinds> bucket_sources;
    std::array<std::array<std::array<Slot, kNearest>, kLowBuckets>, kKinds> bucket_nearest;
    MixWeights<3> bucket_mix;
    std::array<Refinement, kBuckets> bucket_refinement;

    std::array<Slot, kBuckets + 1> place;  ///< first bit of the place in a bucket

    /// Magnitudes of mean e decay like (e / (e + 1))^|q|: a start that small levels never outgrow.
    LevelModel() {
        for (std::uint32_t c = 0; c < kExpected; ++c) {
            const std::uint64_t weight = log_class_floor(c) + 1;
            const Slot start((weight << 32) / (weight + kUnitExpected), 4);
            for (auto& slots : zero_expected) slots[c] = start;
            for (auto& kind : bucket_expected)
                for (auto& slots : kind) slots[c] = start;
        }
    }
};

}  // namespace relief::codec
