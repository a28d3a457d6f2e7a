#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "codec/dense_mixing.h"
#include "codec/dense_tables.h"
#include "codec/log_class.h"
#include "codec/magnitude.h"

namespace relief::codec::dense {

/// What is known of a quotient before it is coded.
struct Situation {
    std::size_t kind;     ///< of Kind
    std::size_t scale;    ///< class of the expected magnitude, under kScales
    std::size_t texture;  ///< class of the texture, under kScales
    std::size_t sums;     ///< classes of the magnitudes around and of the nearest samples
    std::size_t signs;    ///< of two causal quotients, under kSignPairs
    float lost;           ///< what rounding took from the prediction, in steps
    float dispute;        ///< by how much the second opinion is higher, in steps
    bool exact;           ///< the step is 1
};

inline constexpr std::size_t kSumPairs = std::size_t{kSums} * kSums;
inline constexpr std::size_t kSignPairs = 9;

/// 0 .. N: how many of the limits |x| reaches.
template <std::size_t N>
std::size_t size_class(float x, const std::array<float, N>& limits) {
    std::size_t reached = 0;
    for (const float limit : limits) reached += std::abs(x) >= limit;
    return reached;
}

/// All estimates of a tile in one table. "Nodes" are the decisions of a quotient: 0 the zero flag,
/// 1 + u "the bucket is beyond u", the last one for all further u.
class Contexts {
  public:
    static constexpr std::size_t kNodes = 16;

    Estimate* by_scale(const Situation& s) {
        return &estimates_[kByScale + (s.kind * kScales + s.scale) * kNodes];
    }
    Estimate* by_sums(const Situation& s) {
        return &estimates_[kBySums + (s.kind * kSumPairs + s.sums) * kNodes];
    }
    Estimate* by_texture(const Situation& s) {
        const std::size_t textures = (s.kind * kTextures + s.texture / 2) * kTextures;
        return &estimates_[kByTexture + (textures + s.scale / 2) * kNodes];
    }

    // With step 1 what rounding took tells much of the nearest integers: the first three nodes have
    // contexts of their own. lean: 0, or the class of |lost|, plus 4 for a sign that agrees.
    Estimate* exact_by_scale(const Situation& s, std::size_t lean) {
        return &estimates_[kExactByScale +
                           ((s.kind * kScales + s.scale) * kLeans + lean) * kExactNodes];
    }
    Estimate* exact_by_sums(const Situation& s, std::size_t lean) {
        return &estimates_[kExactBySums +
                           ((s.kind * kSumPairs + s.sums) * kLeans + lean) * kExactNodes];
    }

    Estimate& sign_by_lean(const Situation& s, std::size_t lean) {
        return estimates_[kSignByLean + (s.kind * kSignPairs + s.signs) * kLeans + lean];
    }
    Estimate& sign_by_scale(const Situation& s) {
        return estimates_[kSignByScale + s.signs * kScales + s.scale];
    }
    Estimate& sign_by_dispute(std::size_t lean, std::size_t dispute) {
        return estimates_[kSignByDispute + lean * kDisputes + dispute];
    }
    Estimate& place(std::size_t bucket) { return estimates_[kPlace + bucket]; }

    void trust_at_most(std::uint32_t visits) {
        for (Estimate& estimate : estimates_) estimate.trust_at_most(visits);
    }

    static constexpr std::size_t kLeans = 2 * kLostLimits.size() + 1;
    static constexpr std::size_t kDisputes = 2 * kDisputeLimits.size() + 1;
    static constexpr std::size_t kBuckets = 61;
    static constexpr std::size_t kExactNodes = 3;

  private:
    static constexpr std::size_t kTextures = kScales / 2;
    static constexpr std::size_t kByScale = 0;
    static constexpr std::size_t kBySums = kByScale + kKinds * kScales * kNodes;
    static constexpr std::size_t kByTexture = kBySums + kKinds * kSumPairs * kNodes;
    static constexpr std::size_t kExactByScale =
        kByTexture + kKinds * kTextures * kTextures * kNodes;
    static constexpr std::size_t kExactBySums =
        kExactByScale + kKinds * kScales * kLeans * kExactNodes;
    static constexpr std::size_t kSignByLean =
        kExactBySums + kKinds * kSumPairs * kLeans * kExactNodes;
    static constexpr std::size_t kSignByScale = kSignByLean + kKinds * kSignPairs * kLeans;
    static constexpr std::size_t kSignByDispute = kSignByScale + kSignPairs * kScales;
    static constexpr std::size_t kPlace = kSignByDispute + kLeans * kDisputes;
    static constexpr std::size_t kSize = kPlace + kBuckets + 1;

    alignas(
        64) std::array<Estimate, kSize> estimates_;  // the nodes of a context share a cache line
};

/// Everything that coding quotients learns.
struct DenseModel {
    Contexts contexts;
    std::array<std::array<Mixer, kCoarseScales>, kKinds> zero_mixer;
    std::array<Mixer, kKinds> sign_mixer;
    std::array<std::array<Mixer, kCoarseScales>, Contexts::kNodes> beyond_mixer;
    std::array<std::array<Refinement, kScales>, kKinds> zero_refinement;
};

/// Codes quotients: a zero flag, the sign, the bucket of |q| - 1 in unary, the place in the bucket.
/// One text for encoder and decoder: see range_coder.h.
template <class Coder>
class QuotientCoder {
  public:
    QuotientCoder(Coder& coder, DenseModel& model) : coder_(coder), model_(model) {}

    std::int32_t code(std::int32_t q, const Situation& s) {
        const std::size_t fraction = s.exact ? size_class(s.lost, kLostLimits) : 0;
        if (!code_nonzero(q != 0, s, fraction)) return 0;
        const bool negative = code_sign(q < 0, s);
        const std::size_t lean =
            fraction == 0 || negative != (s.lost < 0) ? fraction : fraction + kLostLimits.size();
        const std::uint32_t excess = Coder::kDecodes ? 0 : magnitude_of(q) - 1;
        const std::uint32_t bucket = code_bucket(bucket_of(excess), s, lean);
        const std::uint32_t magnitude = 1 + (bucket < 4 ? bucket : code_place(excess, bucket));
        return static_cast<std::int32_t>(negative ? 0U - magnitude : magnitude);
    }

  private:
    bool code_nonzero(bool nonzero, const Situation& s, std::size_t fraction) {
        Contexts& contexts = model_.contexts;
        const Mixer::Estimates estimates = {
            s.exact ? contexts.exact_by_scale(s, fraction) : contexts.by_scale(s),
            s.exact ? contexts.exact_by_sums(s, fraction) : contexts.by_sums(s),
            contexts.by_texture(s)};
        return code_refined(coder_, nonzero, estimates,
                            model_.zero_mixer[s.kind][coarse_scale(s.scale)],
                            model_.zero_refinement[s.kind][s.scale]);
    }

    bool code_sign(bool negative, const Situation& s) {
        Contexts& contexts = model_.contexts;
        const std::size_t size = size_class(s.lost, kLostLimits);
        const std::size_t lean = size == 0 || s.lost > 0 ? size : size + kLostLimits.size();
        const std::size_t distance = size_class(s.dispute, kDisputeLimits);
        const std::size_t dispute =
            s.dispute < 0 ? kDisputeLimits.size() - distance : kDisputeLimits.size() + distance;
        return code_mixed(coder_, negative,
                          {&contexts.sign_by_lean(s, lean), &contexts.sign_by_scale(s),
                           &contexts.sign_by_dispute(lean, dispute)},
                          model_.sign_mixer[s.kind]);
    }

    std::uint32_t code_bucket(std::uint32_t bucket, const Situation& s, std::size_t lean) {
        Contexts& contexts = model_.contexts;
        Estimate* const by_scale = contexts.by_scale(s);
        Estimate* const by_sums = contexts.by_sums(s);
        Estimate* const by_texture = contexts.by_texture(s);
        Estimate* const exact_by_scale = contexts.exact_by_scale(s, lean);
        Estimate* const exact_by_sums = contexts.exact_by_sums(s, lean);
        const std::size_t coarse = coarse_scale(s.scale);
        for (std::uint32_t u = 0; u < Contexts::kBuckets; ++u) {
            const std::size_t node = std::min<std::size_t>(u + 1, Contexts::kNodes - 1);
            const bool exact = s.exact && node < Contexts::kExactNodes;
            if (!code_mixed(coder_, bucket > u,
                            {(exact ? exact_by_scale : by_scale) + node,
                             (exact ? exact_by_sums : by_sums) + node, by_texture + node},
                            model_.beyond_mixer[node][coarse]))
                return u;
        }
        return Contexts::kBuckets;
    }

    /// What is left of an excess of bucket 4 or more: its first bit is modelled.
    std::uint32_t code_place(std::uint32_t excess, std::uint32_t bucket) {
        const int raw = static_cast<int>(bucket / 2) - 2;
        const std::uint32_t base = (2 + (bucket & 1)) << (raw + 1);
        Estimate& estimate = model_.contexts.place(bucket);
        const bool upper =
            coder_.code(((excess - base) >> raw & 1) != 0, codable(estimate.twelve_bits() << 4));
        estimate.update(upper);
        return base + (static_cast<std::uint32_t>(upper) << raw) +
               code_low_bits(coder_, excess - base, raw);
    }

    Coder& coder_;
    DenseModel& model_;
};

}  // namespace relief::codec::dense
