#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

/// The numbers of the dense profile of the closed loop: which samples predict, with which weights
/// they start, and how the expected magnitude of a quotient is made. Source: codec-closed-loop,
/// section 4.
namespace relief::codec::dense {

/// What is coded: D samples; E samples on odd rows, whose vertical neighbours are EE; E samples on
/// even rows, whose horizontal neighbours are EE.
enum class Kind : std::uint8_t { Diagonal, Vertical, Horizontal };
inline constexpr std::size_t kKinds = 3;

struct Offset {
    int row = 0;
    int col = 0;
};

/// A sample to the west that the same row has just decoded: the only one that a row cannot know
/// before it starts.
inline constexpr Offset kWest = {0, -2};

/// An input of the prediction: the sum of the samples at one or two places, each less the base. An
/// unused second place is {0, 0}.
struct Feature {
    Offset first;
    Offset second = {};
};
inline constexpr std::size_t kFeatures = 16;

/// How samples of one kind are predicted: base, the mean of the four nearest, plus weighted
/// features.
struct Stencil {
    /// Opposite pairs: {0, 3} and {1, 2}. E samples: {0, 3} the EE pair, {1, 2} the D pair.
    std::array<Offset, 4> nearest;
    std::array<Feature, kFeatures> features;  ///< the first is kWest, the paired ones are the last
    std::size_t singles;                      ///< features that are not paired
    std::array<double, kFeatures> weights;    ///< before anything is learnt
    /// The second opinion: base + second_weight (sum of the ring less as many bases).
    std::array<Offset, 8> ring;
    std::size_t ring_size;
    double second_weight;
    double ring_texture;  ///< weight of |ring| in the texture
    /// Samples of the same pass that are decoded, besides the west one, and how often their |q|
    /// counts in the sum of magnitudes around.
    std::array<Offset, 3> causal;
    std::array<std::int32_t, 3> causal_shares;
    std::int32_t west_share;
    std::array<Offset, 2> signs;  ///< of the quotients whose signs are contexts
    /// Pairs of the nearest samples: those that were decoded last, and the others.
    std::array<std::size_t, 2> late;
    std::array<std::size_t, 2> early;
};

inline constexpr std::array<Stencil, kKinds> kStencils = {{
    {.nearest = {{{-1, -1}, {-1, 1}, {1, -1}, {1, 1}}},
     .features = {{{kWest},
                   {{-1, -1}},
                   {{-1, 1}},
                   {{1, -1}},
                   {{-2, -2}},
                   {{-1, -3}},
                   {{-1, 3}},
                   {{1, -3}},
                   {{1, 3}},
                   {{-3, -1}},
                   {{-3, 1}},
                   {{3, -1}},
                   {{3, 1}},
                   {{-2, 0}},
                   {{-2, 2}},
                   {{-3, -3}, {3, 3}}}},
     .singles = 15,
     .weights = {.06, .04, .04, 0, -.04, -.035, -.035, -.05, -.035, .02, -.025, -.03, -.04, -.08},
     .ring = {{{-1, -3}, {-1, 3}, {1, -3}, {1, 3}, {-3, -1}, {-3, 1}, {3, -1}, {3, 1}}},
     .ring_size = 8,
     .second_weight = -1 / 25.6,
     .ring_texture = .075,
     .causal = {{{-2, 0}, {-2, -2}, {-2, 2}}},
     .causal_shares = {2, 1, 1},
     .west_share = 2,
     .signs = {{kWest, {-2, 0}}},
     .late = {0, 3},
     .early = {1, 2}},
    {.nearest = {{{-1, 0}, {0, -1}, {0, 1}, {1, 0}}},
     .features = {{{kWest},
                   {{-1, 0}},
                   {{0, -1}},
                   {{1, 0}},
                   {{-2, -2}},
                   {{-3, 0}},
                   {{3, 0}},
                   {{0, -3}},
                   {{0, 3}},
                   {{-1, -1}},
                   {{-1, 1}},
                   {{-2, 0}},
                   {{-2, -1}, {-2, 1}},
                   {{2, -1}, {2, 1}},
                   {{-1, -2}, {-1, 2}},
                   {{1, -2}, {1, 2}}}},
     .singles = 12,
     .weights = {-.08, -.1, .05, -.13, 0, .01, .005, .01, -.01, 0, 0, -.06, -.005, -.035, -.035,
                 -.03},
     .ring = {{{-3, 0}, {3, 0}, {0, -3}, {0, 3}}},
     .ring_size = 4,
     .second_weight = -.05,
     .ring_texture = .05,
     .causal = {{{-1, -1}, {-1, 1}, {-2, 0}}},
     .causal_shares = {2, 2, 1},
     .west_share = 1,
     .signs = {{{-1, -1}, {-1, 1}}},
     .late = {1, 2},
     .early = {0, 3}},
    {.nearest = {{{0, -1}, {-1, 0}, {1, 0}, {0, 1}}},
     .features = {{{kWest},
                   {{0, -1}},
                   {{-1, 0}},
                   {{0, 1}},
                   {{-2, -2}},
                   {{0, -3}},
                   {{0, 3}},
                   {{-3, 0}},
                   {{3, 0}},
                   {{-1, -1}},
                   {{-1, 1}},
                   {{-2, 0}},
                   {{-1, -2}, {1, -2}},
                   {{-1, 2}, {1, 2}},
                   {{-2, -1}, {2, -1}},
                   {{-2, 1}, {2, 1}}}},
     .singles = 12,
     .weights = {-.08, .15, .03, .09, 0, .01, 0, .015, .005, 0, 0, -.04, -.018, -.035, -.035, -.03},
     .ring = {{{0, -3}, {0, 3}, {-3, 0}, {3, 0}}},
     .ring_size = 4,
     .second_weight = -.05,
     .ring_texture = .05,
     .causal = {{{-1, -1}, {-1, 1}, {-2, 0}}},
     .causal_shares = {2, 2, 1},
     .west_share = 1,
     .signs = {{{-1, -1}, {-1, 1}}},
     .late = {1, 2},
     .early = {0, 3}},
}};

/// The expected magnitude of a quotient: section 4.4. Texture and gap are in steps.
struct ScaleWeights {
    float around = .05F;   ///< of the sum of |q| around, near ones twice
    float late = .045F;    ///< of |q| of the nearest samples decoded last
    float early = .004F;   ///< of |q| of the other nearest samples
    float texture = .09F;  ///< of how much the nearest samples and the ring bend
    float gap = .07F;      ///< of the distance of the two opinions
    float least = .08F;
};
inline constexpr ScaleWeights kScale;

/// How weights are learnt: section 4.2. A sample with expected magnitude m counts
/// 1 / ((m^2 + 1) step^2).
struct LearningRules {
    double fade = .3;           ///< of what earlier levels taught, at each new level
    double ridge = 200;         ///< towards the start
    double trace_ridge = 1e-3;  ///< of the mean of the diagonal
    double echo = .3;  ///< further weight of a sample that repeats its prediction (q = 0, step > 1)
    std::size_t batch = 64;        ///< equations between solutions, which are made at ends of rows
    int every_sample_from = 3;     ///< the finest level where all samples teach
    std::uint32_t stride = 4;      ///< on finer levels only each fourth one, and ..
    float surprising_below = .7F;  ///< .. those with q != 0 and an expected magnitude under this
};
inline constexpr LearningRules kLearning;

/// How a prediction is corrected by the mean error of its context: section 4.3. Errors in steps.
struct BiasRules {
    double share = .8;          ///< of the mean error that is added
    float error_limit = 10;     ///< of one error
    std::uint32_t prior = 4;    ///< the first error counts 1 / prior
    std::uint32_t memory = 48;  ///< an error never counts less than 1 / memory
};
inline constexpr BiasRules kBias;

/// What a new level trusts an estimate of the coarser levels: as many decisions at most.
inline constexpr std::uint32_t kInheritedVisits = 10;

/// Limits of the classes of |prediction - rounded prediction| / step and of |second opinion -
/// prediction| / step.
inline constexpr std::array<float, 4> kLostLimits = {.04F, .12F, .22F, .34F};
inline constexpr std::array<float, 5> kDisputeLimits = {.05F, .15F, .35F, .8F, 2.F};

/// Classes of octave_class.
inline constexpr std::uint32_t kScales = 40;

/// Four classes an octave from 1/32 up, 0 below; taken from the bits of v >= 0.
inline std::uint32_t octave_class(float v) {
    constexpr std::int32_t first = 4 * (127 - 5) - 1;
    const auto c = static_cast<std::int32_t>(std::bit_cast<std::uint32_t>(v) >> 21) - first;
    return static_cast<std::uint32_t>(std::clamp(c, 0, static_cast<std::int32_t>(kScales) - 1));
}

/// Scales in 16 classes, for mixers, refinements and corrections.
inline constexpr std::size_t kCoarseScales = kScales * 2 / 5;

inline std::size_t coarse_scale(std::size_t scale) {
    return scale * 2 / 5;
}

/// Classes of small sums of magnitudes.
inline constexpr std::uint32_t kSums = 12;
inline constexpr std::array<std::uint8_t, 45> kSumClasses = {
    0, 1, 2, 3, 4, 5, 5,  6,  6,  6,  7,  7,  7,  7,  8,  8,  8,  8,  8,  8,  9,  9, 9,
    9, 9, 9, 9, 9, 9, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 11};

inline std::uint32_t sum_class(std::int32_t sum) {
    return kSumClasses[static_cast<std::size_t>(std::min(sum, 44))];
}

}  // namespace relief::codec::dense
