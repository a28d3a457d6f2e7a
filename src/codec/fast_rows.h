#pragma once

#include <array>
#include <cstdint>

/// Rows of samples in the fast profile: prediction, context classes, quantisation. Vector kernels
/// with scalar twins (relief/core/simd.h), equal to the bit; no output may overlap an input.
/// Source: codec-closed-loop, section 7; docs/codec.md.
namespace relief::codec::fast {

inline constexpr int kClasses = 24;
/// The class of holes and of the padding behind a row: always q = 0, coded in no bits.
inline constexpr std::uint8_t kSilent = kClasses;

/// |q| = 0 .. 4 are tokens of their own, then two tokens an octave: [5, 6] [7, 8] [9, 12] [13, 16]
/// .. up to 32768; the last token is for all beyond.
inline constexpr int kTokens = 32;
inline constexpr std::int32_t kOwnTokens = 5;

/// Where the samples that predict sample k of a row lie: at element k of each array.
struct Neighbours {
    std::array<const std::int32_t*, 4> near;  ///< 0 is opposite to 1, 2 to 3
    std::array<const std::int32_t*, 8> far;
    std::array<const std::int16_t*, 4> near_quotients;
    std::array<const std::int16_t*, 2> earlier_quotients;  ///< of the row coded before, same pass
};

/// What all rows of a level share. Values are relative to `origin`.
struct RowRule {
    std::int32_t origin;
    std::int32_t lowest;  ///< predictions lie in lowest .. highest,
    std::int32_t highest;
    std::int32_t floor;  ///< decoded values in floor .. ceiling, one span further
    std::int32_t ceiling;
    std::int32_t step;
    bool wide;  ///< sums of values need more than 32 bits

    RowRule(std::int32_t level_lowest, std::int32_t level_highest, std::int32_t level_step);
};

/// even[k] = samples[2 k], moved into floor .. ceiling and made relative to the origin.
void split_values(const std::int32_t* samples, std::int64_t n, const RowRule& rule,
                  std::int32_t* even);
void split_quotients(const std::int16_t* samples, std::int64_t n, std::int16_t* even);

/// samples[2 k] = even[k], samples[2 k + 1] = odd[k]; values leave the origin.
void merge_values(const std::int32_t* even, const std::int32_t* odd, std::int64_t n,
                  const RowRule& rule, std::int32_t* samples);
void merge_quotients(const std::int16_t* even, const std::int16_t* odd, std::int64_t n,
                     std::int16_t* samples);

/// predictions[k] = floor((10 sum(near) - sum(far) + 16) / 32), clamped.
void predict_row(const Neighbours& neighbours, std::int64_t n, const RowRule& rule,
                 std::int32_t* predictions);

/// The same with classes[k]: how large quotients are expected, from the differences of the
/// neighbours and their quotients.
void predict_row(const Neighbours& neighbours, std::int64_t n, const RowRule& rule,
                 std::int32_t* predictions, std::uint8_t* classes);

/// quotients[k]: the nearest of (sources[k] - predictions[k]) / step, 0 where classes[k] is
/// kSilent; tokens[k]: that of |quotients[k]|.
void quantise_row(const std::int32_t* sources, const std::int32_t* predictions,
                  const std::uint8_t* classes, std::int64_t n, const RowRule& rule,
                  std::int32_t* quotients, std::uint8_t* tokens);

/// values[k] = predictions[k] + step quotients[k], modulo 2^32 and then moved into floor ..
/// ceiling; kept[k]: the quotient, at most 30000 in magnitude.
void reconstruct_row(const std::int32_t* predictions, const std::int32_t* quotients, std::int64_t n,
                     const RowRule& rule, std::int32_t* values, std::int16_t* kept);

}  // namespace relief::codec::fast
