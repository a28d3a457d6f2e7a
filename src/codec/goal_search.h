#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "relief/codec/raster_codec.h"

/// How encoders look for what meets a goal: by trials of a unit, a step or a tolerance, with which
/// errors grow and sizes fall.
namespace relief::codec {

/// Errors: InvalidArgument for goals that are negative or not numbers, and for less than a byte.
[[nodiscard]] Status check_goal(const Goal& goal);

[[nodiscard]] inline Error cancelled_error() {
    return Error{ErrorCode::Cancelled, "cancelled", ""};
}

/// What was made with a unit, and the share of the goal that it uses up: it meets the goal up to 1.
template <class Candidate>
struct Tried {
    Candidate candidate;
    double unit = 0;
    double share = 0;
};

/// When a search ends.
struct SearchLimits {
    int trials = 16;
    double close_enough = 1;  ///< the share of the goal that is used up
    double narrow = 1;        ///< the ratio of the least unit that fails and the largest that does
};
/// The shares that the next unit of largest_unit may be aimed by.
struct AimLimits {
    double least = 0.01;
    double most = 100;
};

/// The candidate with the largest unit that meets an error goal, by aiming as if errors grew a
/// little faster than units, from a first unit on; none if no unit down to `least` does.
/// try_unit(unit) -> Result<Tried>: the unit tried may be another one nearby. cancelled(part done).
/// Errors: those of try_unit; Cancelled.
template <class Candidate, class TryUnit, class Cancel>
Result<std::optional<Candidate>> largest_unit(double unit, double least, const SearchLimits& limits,
                                              const AimLimits& aims, TryUnit try_unit,
                                              Cancel cancelled) {
    std::optional<Candidate> best;
    double good = 0;
    double bad = std::numeric_limits<double>::infinity();
    for (int k = 0; k < limits.trials && unit >= least && !(bad / good < limits.narrow); ++k) {
        if (cancelled(static_cast<double>(k) / limits.trials)) return cancelled_error();
        RELIEF_TRY(Tried<Candidate> tried, try_unit(unit));
        const double share = tried.share;
        if (!(share <= 1)) {
            bad = std::min(bad, tried.unit);
        } else if (tried.unit > good) {
            good = tried.unit;
            best = std::move(tried.candidate);
        }
        if (share <= 1 && share >= limits.close_enough) break;
        const double aimed_share = 0.5 + 0.5 * limits.close_enough;
        const double aim =
            tried.unit * std::pow(std::clamp(share, aims.least, aims.most) / aimed_share, -0.9);
        unit = aim > good && aim < bad ? aim : std::sqrt(good * bad);
    }
    return best;
}

/// The candidate nearest to the goal from within, by halving the ratio of a unit that meets it,
/// with `best`, and one that does not. As largest_unit otherwise.
template <class Candidate, class TryUnit, class Cancel>
Result<Tried<Candidate>> bisect(Tried<Candidate> best, double bad, const SearchLimits& limits,
                                TryUnit try_unit, Cancel cancelled) {
    const auto ratio = [&] { return std::max(best.unit / bad, bad / best.unit); };
    for (int k = 0;
         k < limits.trials && ratio() > limits.narrow && best.share < limits.close_enough; ++k) {
        if (cancelled(static_cast<double>(k) / limits.trials)) return cancelled_error();
        RELIEF_TRY(Tried<Candidate> tried, try_unit(std::sqrt(best.unit) * std::sqrt(bad)));
        if (tried.share <= 1)
            best = std::move(tried);
        else
            bad = tried.unit;
    }
    return best;
}

}  // namespace relief::codec
