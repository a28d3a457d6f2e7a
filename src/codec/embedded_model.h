#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "codec/level_model.h"
#include "codec/probability.h"

namespace relief::codec {

/// Everything that the coder of a stream learns. docs/format.md lists the same tables.
struct EmbeddedModel {
    static constexpr std::uint32_t kKinds = 4;
    static constexpr std::uint32_t kExpected = 48;
    static constexpr std::uint32_t kNear = 16;
    static constexpr std::uint32_t kSiblings = 8;
    static constexpr std::uint32_t kPlanes = 16;
    static constexpr std::uint32_t kPrefixes = 11;
    static constexpr std::uint32_t kPairs = 8;

    template <std::uint32_t n>
    using Slots = std::array<Slot, n>;
    template <std::uint32_t n>
    using Mixes = std::array<MixWeights<n>, 64>;

    Slots<kKinds * kNear> significant_near;
    Slots<kKinds * kPlanes * kExpected> significant_expected;
    Slots<kKinds * kSiblings * kExpected> significant_siblings;
    std::array<Refinement, kKinds * kExpected> significant_refinement;

    Slots<kKinds * 81> sign_ring;
    Slots<kKinds * 81> sign_siblings;
    Slots<kKinds * 9 * kPairs> sign_pair;
    std::array<Refinement, kKinds> sign_refinement;

    Slots<kKinds * kPrefixes> bit_prefix;
    Slots<kKinds * kPlanes * kPrefixes> bit_plane;
    Slots<kKinds * kNear * kPrefixes> bit_near;
    std::array<Refinement, kKinds * kPrefixes> bit_refinement;

    MixWeights<3> significant_mix[kKinds], significant_mix_expected[kExpected];
    MixWeights<3> sign_mix[kKinds], sign_mix2[1];
    MixWeights<3> bit_mix[kKinds], bit_mix2[kPrefixes];
};

}  // namespace relief::codec
