#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <vector>

namespace relief::codec::dense {

/// Grids that were interpolated from coarser ones hold samples that are exact means of two others,
/// up to rounding, which no prediction learnt from all samples finds. With step 1 this class
/// follows how well such rules do around each E sample of one kind, and tells where one holds.
class InterpolationRules {
  public:
    /// The mean of the EE pair; of the D pair; the sample that makes the first of the D pair the
    /// mean of its neighbours.
    static constexpr std::size_t kCount = 3;
    /// Twice the predictions.
    using Predictions = std::array<std::int64_t, kCount>;

    /// How much better than what was learnt each rule did where it seemed to hold.
    using Scores = std::array<std::int32_t, kCount>;

    /// For rows of `count` samples.
    InterpolationRules(std::int64_t count, Scores& scores) : scores_(scores) {
        Misses unknown;
        unknown.fill(kMost);
        current_.assign(static_cast<std::size_t>(count) + 2, unknown);  // one more on either side
        above_ = current_;
    }

    void begin_row() { current_.swap(above_); }

    /// The rule that holds at the four nearest samples coded before sample k, if learnt predictions
    /// do not and it has done better than they in such places.
    std::optional<std::size_t> find(std::int64_t k) {
        const Misses& west = current_[static_cast<std::size_t>(k)];
        const Misses* const above = &above_[static_cast<std::size_t>(k)];
        const auto missed = [&](std::size_t rule) {
            return west[rule] + above[0][rule] + above[1][rule] + above[2][rule] != 0;
        };
        candidate_ = kCount;
        if (!missed(kLearnt)) return {};
        candidate_ = 0;
        while (candidate_ < kCount && missed(candidate_)) ++candidate_;
        if (candidate_ == kCount || scores_[candidate_] <= 0) return {};
        return candidate_;
    }

    /// Sample k, for which find was called, is `value`.
    void learn(std::int64_t k, std::int32_t value, const Predictions& rules, double learnt) {
        // The last rule doubles the rounding of the mean that it inverts.
        const std::int64_t twice = 2 * std::int64_t{value};
        const Misses misses = {miss(twice - rules[0]), miss(twice - rules[1]),
                               miss((twice - rules[2]) / 2), miss(2 * (value - learnt))};
        current_[static_cast<std::size_t>(k) + 1] = misses;
        if (candidate_ == kCount) return;
        const std::int32_t gain = misses[kLearnt] - miss(twice - rules[candidate_]);
        std::int32_t& score = scores_[candidate_];
        score = std::clamp(score + gain, -kLargestScore, kLargestScore);
    }

    /// Sample k is a hole.
    void skip(std::int64_t k) { current_[static_cast<std::size_t>(k) + 1].fill(kMost); }

  private:
    static constexpr std::size_t kLearnt = kCount;
    static constexpr std::uint8_t kMost = 16;
    static constexpr std::int32_t kLargestScore = 256;

    /// Of the rules and of what was learnt: halves beyond what rounding explains.
    using Misses = std::array<std::uint8_t, kCount + 1>;

    static std::uint8_t miss(double halves) {
        return static_cast<std::uint8_t>(std::clamp<double>(std::abs(halves) - 1, 0, kMost));
    }
    static std::uint8_t miss(std::int64_t halves) {
        return static_cast<std::uint8_t>(std::clamp<std::int64_t>(std::abs(halves) - 1, 0, kMost));
    }

    Scores& scores_;
    std::vector<Misses> current_;
    std::vector<Misses> above_;
    std::size_t candidate_ = kCount;  ///< of the last find; kCount: none
};

}  // namespace relief::codec::dense
