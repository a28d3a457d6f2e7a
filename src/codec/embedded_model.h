#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "codec/embedded_mixing.h"
#include "codec/embedded_priors.h"

namespace relief::codec {

/// The contexts of a stream: sets one after another. Of the three sets of a decision profile Fast
/// uses the first.
struct EmbeddedContexts {
    static constexpr std::uint32_t kKinds = 4;      ///< scaling band, channels 1, 2, all others
    static constexpr std::uint32_t kPlanes = 8;     ///< higher planes share the last
    static constexpr std::uint32_t kExpected = 40;  ///< expected magnitude, four an octave
    static constexpr std::uint32_t kNear = 16;      ///< eight neighbours, two an octave
    static constexpr std::uint32_t kSiblings = 8;   ///< siblings, one an octave
    static constexpr std::uint32_t kSigns = 81;     ///< of four coefficients: -, unknown, +
    static constexpr std::uint32_t kSizes = 8;      ///< of W + E, one an octave
    static constexpr std::uint32_t kPrefixes = 11;  ///< known bits 1 .. 7, 8+, 16+, 32+, 64+

    static constexpr std::uint32_t kGap = 0;
    static constexpr std::uint32_t kFoundExpected = kGap + kKinds * kPlanes;
    static constexpr std::uint32_t kFoundNear = kFoundExpected + kKinds * kPlanes * kExpected;
    static constexpr std::uint32_t kFoundSiblings = kFoundNear + kKinds * kNear;
    static constexpr std::uint32_t kSignSiblings = kFoundSiblings + kKinds * kSiblings * kExpected;
    static constexpr std::uint32_t kSignRing = kSignSiblings + kKinds * kSigns;
    static constexpr std::uint32_t kSignPair = kSignRing + kKinds * kSigns;
    static constexpr std::uint32_t kBitPlane = kSignPair + kKinds * 9 * kSizes;
    static constexpr std::uint32_t kBitPrefix = kBitPlane + kKinds * kPlanes * kPrefixes;
    static constexpr std::uint32_t kBitNear = kBitPrefix + kKinds * kPrefixes;
    static constexpr std::uint32_t kCount = kBitNear + kKinds * kNear * kPrefixes;
};

/// Weights of one sort of decision: for each kind of band, and for each class of what tells most.
template <int kSets, std::uint32_t kClasses>
struct EmbeddedWeights {
    std::array<Blend<kSets>, EmbeddedContexts::kKinds> by_kind;
    std::array<Blend<kSets>, kClasses> by_class;
};

/// Everything that the coder of a stream learns.
template <int kSets>
struct EmbeddedModel {
    std::array<Chance, EmbeddedContexts::kCount> chances;
    EmbeddedWeights<kSets, EmbeddedContexts::kExpected> found;
    EmbeddedWeights<kSets, 1> sign;
    EmbeddedWeights<kSets, EmbeddedContexts::kPrefixes> bit;

    EmbeddedModel() {
        for (std::size_t k = 0; k < chances.size(); ++k) {
            const std::int32_t odds = kPriorStep * (kEmbeddedPriors[k] - kPriorEven);
            const std::uint32_t one = kOdds.squash[static_cast<std::size_t>(odds + kOddsLimit)];
            chances[k] = {one << 16, kPriorVisits};
        }
    }
};

}  // namespace relief::codec
