#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "codec/goal_search.h"
#include "codec/raster_header.h"
#include "relief/codec/oracle.h"

/// How the open loop chooses steps and coefficients.
namespace relief::codec {

/// Beyond it all values are 0.
inline constexpr double kLargestStep = 1e99;

/// Means of the components of a scaling band, of 5 digits.
[[nodiscard]] std::vector<double> means_of(const multires::Planes<double>& scaling);

/// Errors: BadInput for a valid sample that is not a number of at most 1e45, naming its place in
/// the raster: `part` begins at (row0, col0).
[[nodiscard]] Status check_samples(const Raster& part, std::int64_t row0, std::int64_t col0);

[[nodiscard]] Pyramid<double> copy_of(const Pyramid<double>& pyramid);

/// The pyramid whose coefficients are to be quantised with the step and means of `coding`. Least
/// squares over those that will not be zero takes 10 to 20 % off the file at the same error: atoms
/// of one level overlap and can take over what their neighbours lose. `fixed_scaling`: the scaling
/// band is all zero and stays so. Effort::Select copies. Complexity: O(samples).
[[nodiscard]] Pyramid<double> improved(Pyramid<double> exact, const Target& target,
                                       const PyramidCoding& coding, Effort effort,
                                       bool fixed_scaling = false);

/// Finds the unit where `measure_of(candidate)` meets 1 from below, candidates being `make(unit)`:
/// what a step of `unit` gives, or of the least there is. growing: the measure grows with the unit.
/// Keeps the candidate that is closest below 1, and stops when one measures `close_enough`; none:
/// no candidate measures up to 1. cancelled(done): whether to stop. Errors: those of `make`;
/// Cancelled.
template <class Candidate, class Make, class MeasureOf, class Cancel>
Result<std::optional<Candidate>> search(double unit, bool growing, double close_enough, Make make,
                                        MeasureOf measure_of, Cancel cancelled) {
    constexpr int most_steps = 24;
    std::optional<Candidate> best;
    double best_measure = 0;
    double below = 0;  // log units and log measures of the bracket
    double below_measure = 0;
    double above = 0;
    double above_measure = 0;
    bool has_below = false;
    bool has_above = false;
    for (int step = 0; step < most_steps; ++step) {
        if (cancelled(static_cast<double>(step) / most_steps)) return cancelled_error();
        RELIEF_TRY(Candidate candidate, make(unit));
        const double measure = measure_of(candidate);
        const double logarithm = std::log(std::max(measure, 1e-12));
        if (measure <= 1) {
            if (!best || measure > best_measure) {
                best = std::move(candidate);
                best_measure = measure;
            }
            if (measure >= close_enough) break;
            has_below = true;
            below = std::log(unit);
            below_measure = logarithm;
        } else {
            // The least step there is was taken instead.
            if (growing && candidate.coding.step > 1.01 * unit) break;
            has_above = true;
            above = std::log(unit);
            above_measure = logarithm;
        }
        if (has_below && has_above) {
            if (std::abs(above - below) < 1e-4) break;
            const double part = -below_measure / std::max(above_measure - below_measure, 1e-9);
            unit = std::exp(below + (above - below) * std::clamp(part - 0.01, 0.05, 0.95));
        } else {
            const double factor = std::clamp(std::exp(1.1 * std::abs(logarithm)), 1.02, 16.0);
            unit = (measure > 1) == growing ? unit / factor : unit * factor;
        }
        if (!(unit > 1e-290 && unit < 1e290)) break;
    }
    return best;
}

}  // namespace relief::codec
