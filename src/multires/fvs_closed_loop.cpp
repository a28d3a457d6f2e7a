#include <cmath>
#include <limits>

#include "multires/fvs_functionals.h"
#include "relief/multires/fvs_mesh_coding.h"

namespace relief::multires::fvs_mesh {

using mesh::Quadrangulation;

namespace {

constexpr double kLargestMultiple = std::numeric_limits<std::int32_t>::max();
constexpr int kHalvings = 60;

/// The steps of level m are `step` times these.
struct Units {
    Nodal<double> base;
    std::vector<Details<double>> details;
};

Units units_of(const Hierarchy& hierarchy, int levels, double kappa) {
    Units units{nodal_units(hierarchy.mesh(0), kappa), {}};
    for (int m = 1; m <= levels; ++m)
        units.details.push_back(detail_units(hierarchy.mesh(m - 1), hierarchy.mesh(m), kappa));
    return units;
}

bool positive(double x) {
    return x > 0 && std::isfinite(x);
}

/// Whether all multiples fit.
bool round_to_steps(const std::vector<double>& numbers, const std::vector<double>& units,
                    double step, std::vector<std::int32_t>& multiples) {
    bool fit = true;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
        const double multiple = std::rint(numbers[k] / (step * units[k]));
        fit = fit && std::abs(multiple) <= kLargestMultiple;
        multiples[k] = fit ? static_cast<std::int32_t>(multiple) : 0;
    }
    return fit;
}

void multiply_steps(const std::vector<std::int32_t>& multiples, const std::vector<double>& units,
                    double step, std::vector<double>& numbers) {
    for (std::size_t k = 0; k < multiples.size(); ++k)
        numbers[k] = multiples[k] * (step * units[k]);
}

NodalData dequantised_base(const Quadrangulation& mesh, const Nodal<std::int32_t>& base,
                           const Nodal<double>& units, double step) {
    NodalData data = make_nodal<double>(mesh);
    for_each_nodal([step](const std::vector<std::int32_t>& q, const std::vector<double>& unit,
                          std::vector<double>& out) { multiply_steps(q, unit, step, out); },
                   base, units, data);
    return data;
}

void insert_dequantised(const Quadrangulation& parent, const Details<std::int32_t>& quantised,
                        const Details<double>& units, double step, NodalData& predicted) {
    Details<double> details = make_details<double>(parent);
    for_each_detail([step](const std::vector<std::int32_t>& q, const std::vector<double>& unit,
                           std::vector<double>& out) { multiply_steps(q, unit, step, out); },
                    quantised, units, details);
    insert(parent, details, predicted);
}

/// The restrictions of a spline to all levels: the last is the spline itself.
std::vector<NodalData> all_levels(const Hierarchy& hierarchy, const NodalData& finest) {
    std::vector<NodalData> levels(static_cast<std::size_t>(hierarchy.levels()) + 1);
    levels.back() = finest;
    for (int m = hierarchy.levels(); m > 0; --m)
        levels[m - 1] = restrict_to(hierarchy.mesh(m - 1), levels[m]);
    return levels;
}

struct Coded {
    Quantised code;
    NodalData finest;  ///< as decoded
};

Result<Coded> code_levels(const Hierarchy& hierarchy, const std::vector<NodalData>& levels,
                          const Units& units, double step, double kappa) {
    const Quadrangulation& base = hierarchy.mesh(0);
    Coded out{{step, kappa, make_nodal<std::int32_t>(base), {}}, {}};
    bool fit = true;
    for_each_nodal(
        [&](const std::vector<double>& numbers, const std::vector<double>& unit,
            std::vector<std::int32_t>& q) { fit = round_to_steps(numbers, unit, step, q) && fit; },
        levels[0], units.base, out.code.base);
    out.finest = dequantised_base(base, out.code.base, units.base, step);
    for (int m = 1; m <= hierarchy.levels(); ++m) {
        const Quadrangulation& parent = hierarchy.mesh(m - 1);
        NodalData predicted = predict(parent, out.finest);
        const Details<double> missing = extract(parent, levels[m], predicted);
        out.code.details.push_back(make_details<std::int32_t>(parent));
        for_each_detail(
            [&](const std::vector<double>& numbers, const std::vector<double>& unit,
                std::vector<std::int32_t>& q) {
                fit = round_to_steps(numbers, unit, step, q) && fit;
            },
            missing, units.details[m - 1], out.code.details.back());
        insert_dequantised(parent, out.code.details.back(), units.details[m - 1], step, predicted);
        out.finest = std::move(predicted);
    }
    if (fit) return out;
    return Error{ErrorCode::InvalidArgument,
                 "step_too_small: a number is more than 2^31 - 1 steps; use a larger step",
                 "step " + std::to_string(step)};
}

Status check_steps(double step, double kappa) {
    if (positive(step) && positive(kappa)) return {};
    return Error{ErrorCode::InvalidArgument,
                 "step_not_positive: step and kappa must be positive and finite", ""};
}

/// Bisection for the coarsest step whose certified error is within the tolerance.
class StepSearch {
  public:
    StepSearch(const Hierarchy& hierarchy, const NodalData& finest, double tolerance,
               const ClosedLoopOptions& options)
        : hierarchy_(hierarchy),
          finest_(finest),
          tolerance_(tolerance),
          options_(options),
          levels_(all_levels(hierarchy, finest)),
          units_(units_of(hierarchy, hierarchy.levels(), options.kappa)) {}

    Result<ClosedLoop> run() {
        // On squares half a step of values and kappa / h half steps of derivatives add up to this
        // (section 8.1); on other shapes it is a guess, and halved until it holds.
        double good = tolerance_ / (0.5 + options_.kappa * (0.13125 + 1.0 / 6));
        double bad = 4 * tolerance_;
        for (int k = 0;; ++k) {
            RELIEF_TRY(const bool within, attempt(good));
            if (within) break;
            if (k == kHalvings) return too_small();
            bad = good;
            good *= 0.5;
        }
        for (int k = 0; k < options_.bisections; ++k) {
            const double step = 0.5 * (good + bad);
            RELIEF_TRY(const bool within, attempt(step));
            (within ? good : bad) = step;
        }
        const double bound = bound_of(best_.finest, options_.certificate_refinements);
        if (!(bound <= tolerance_)) return too_small();
        return ClosedLoop{std::move(best_.code), bound};
    }

  private:
    [[nodiscard]] double bound_of(const NodalData& decoded, int refinements) const {
        return error_bound(hierarchy_.mesh(hierarchy_.levels()), finest_, decoded, refinements);
    }

    /// Whether a step keeps the tolerance; if so, its code is kept.
    Result<bool> attempt(double step) {
        if (!positive(step)) return too_small();
        RELIEF_TRY(Coded coded, code_levels(hierarchy_, levels_, units_, step, options_.kappa));
        if (!(bound_of(coded.finest, options_.search_refinements) <= tolerance_)) return false;
        best_ = std::move(coded);
        return true;
    }

    static Error too_small() {
        return {ErrorCode::InvalidArgument,
                "tolerance_too_small: rounding of the data alone exceeds it; ask for a larger one",
                ""};
    }

    const Hierarchy& hierarchy_;
    const NodalData& finest_;
    double tolerance_;
    ClosedLoopOptions options_;
    std::vector<NodalData> levels_;
    Units units_;
    Coded best_;
};

}  // namespace

Result<Quantised> quantise(const Hierarchy& hierarchy, const NodalData& finest, double step,
                           double kappa) {
    RELIEF_CHECK(check_steps(step, kappa));
    RELIEF_CHECK(check(hierarchy.mesh(hierarchy.levels()), finest));
    RELIEF_TRY(Coded coded,
               code_levels(hierarchy, all_levels(hierarchy, finest),
                           units_of(hierarchy, hierarchy.levels(), kappa), step, kappa));
    return std::move(coded.code);
}

Result<NodalData> dequantise(const Hierarchy& hierarchy, const Quantised& code, int level) {
    RELIEF_CHECK(check_steps(code.step, code.kappa));
    RELIEF_CHECK(check_sizes(hierarchy, code.base, code.details, level));
    const Units units = units_of(hierarchy, level, code.kappa);
    NodalData data = dequantised_base(hierarchy.mesh(0), code.base, units.base, code.step);
    for (int m = 1; m <= level; ++m) {
        const Quadrangulation& parent = hierarchy.mesh(m - 1);
        data = predict(parent, data);
        insert_dequantised(parent, code.details[m - 1], units.details[m - 1], code.step, data);
    }
    RELIEF_CHECK(check(hierarchy.mesh(level), data));
    return data;
}

Result<ClosedLoop> quantise_within(const Hierarchy& hierarchy, const NodalData& finest,
                                   double tolerance, const ClosedLoopOptions& options) {
    if (!positive(tolerance))
        return Error{ErrorCode::InvalidArgument,
                     "tolerance_not_positive: the largest error must be positive and finite", ""};
    RELIEF_CHECK(check_steps(tolerance, options.kappa));
    RELIEF_CHECK(check(hierarchy.mesh(hierarchy.levels()), finest));
    return StepSearch(hierarchy, finest, tolerance, options).run();
}

}  // namespace relief::multires::fvs_mesh
