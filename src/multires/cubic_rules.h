#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

/// The rules of scheme `cubic`: all its numbers, and the mirror at the ends of an axis.
namespace relief::multires::cubic {

inline constexpr int kTaps = 6;

/// The spline through the even samples at a point half-way: weights of its six neighbours on either
/// side. Values of the cardinal cubic spline at 1/2, 3/2, .. 11/2, scaled by 1.00027765 so that
/// their sum is 1/2 (docs/cubic.md).
inline constexpr double kHalfwayTaps[kTaps] = {0.60064767026100460175, -0.12744010964082078124,
                                               0.03414747446159166353, -0.00914978820554587289,
                                               0.00245167836059182801, -0.00065692523682143917};

/// A lifting step of taps reads so many rows or columns of the other parity on either side.
inline constexpr std::int64_t kReach = kTaps;

/// Of a fine row or column: 2i is the even one of pair i, 2i + 1 the odd one.
enum class Parity : std::uint8_t { Even, Odd };

constexpr Parity other(Parity parity) {
    return parity == Parity::Even ? Parity::Odd : Parity::Even;
}
constexpr std::size_t index(Parity parity) {
    return static_cast<std::size_t>(parity);
}

/// Index first .. last - 1.
struct Range {
    std::int64_t first = 0;
    std::int64_t last = 0;
};

/// One axis of a fine lattice of n samples, and the pairs of them that are worked on.
struct Axis {
    std::int64_t n = 1;
    Range pairs;

    [[nodiscard]] std::int64_t count(Parity parity) const {
        return (n + 1 - static_cast<std::int64_t>(parity)) / 2;
    }

    /// Members of the pairs and of up to `halo` pairs beyond, as far as they exist.
    [[nodiscard]] Range existing(Parity parity, std::int64_t halo) const {
        const std::int64_t last = std::min(pairs.last + halo, count(parity));
        return {std::min(std::max<std::int64_t>(pairs.first - halo, 0), last), last};
    }

    /// The member that stands for member i, which may lie beyond the ends: sample -y is sample y,
    /// and sample n - 1 + y is sample n - 1 - y, as often as needed. Parities do not mix. Requires
    /// count(parity) >= 1.
    [[nodiscard]] std::int64_t mirrored(Parity parity, std::int64_t i) const {
        if (n == 1) return 0;
        if (i >= 0 && i < count(parity)) return i;
        const std::int64_t period = 2 * (n - 1);
        std::int64_t sample = (2 * i + static_cast<std::int64_t>(parity)) % period;
        if (sample < 0) sample += period;
        return std::min(sample, period - sample) / 2;
    }
};

/// The pair of steps of one level along an axis: members of parity `first` receive their factor
/// times the weighted sum of their neighbours, then the others theirs.
struct Lifting {
    Parity first;
    double even;  ///< factor of the sums that even members receive
    double odd;

    [[nodiscard]] double factor(Parity parity) const { return parity == Parity::Even ? even : odd; }
};

/// Predict odd members, then update even ones with half the adjoint of that.
inline constexpr Lifting kAnalysis{Parity::Odd, 0.5, -1};
inline constexpr Lifting kSynthesis{Parity::Even, -0.5, 1};
/// The transpose of kSynthesis as to sums over the period of the mirrored sequence, which has the
/// first and the last sample once and all others twice.
inline constexpr Lifting kTransposed{Parity::Even, 1, -0.5};

}  // namespace relief::multires::cubic
