#include "relief/multires/ps_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "multires/ps_sites.h"
#include "multires/ps_solver.h"
#include "multires/small_cholesky.h"

namespace relief::multires::ps {

using mesh::Index;

namespace {

constexpr double kLargest = 1e150;
/// Random sign vectors that estimate the trace of the influence matrix.
constexpr std::size_t kProbes = 10;
constexpr double kDegenerate = 1e-12;
/// What is added to the diagonal where smoothing is lost to rounding.
constexpr double kShift = 1e-12;
constexpr int kLeastPower = -12;
constexpr int kMostPower = -3;

/// The k-th of a fixed sequence of random numbers.
std::uint64_t scrambled(std::uint64_t k) {
    std::uint64_t z = (k + 1) * 0x9E3779B97F4A7C15;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return z ^ (z >> 31);
}

using Components = std::span<const std::span<const double>>;

double inner_product(std::span<const Heights> a, std::span<const Heights> b) {
    double sum = 0;
    for (std::size_t v = 0; v < a.size(); ++v)
        sum += a[v][0] * b[v][0] + a[v][1] * b[v][1] + a[v][2] * b[v][2];
    return sum;
}

void add(double factor, std::span<const Heights> b, Coefficients& sum) {
    for (std::size_t v = 0; v < sum.size(); ++v)
        for (std::size_t j = 0; j < 3; ++j) sum[v][j] += factor * b[v][j];
}

Error size_mismatch(std::size_t given, std::size_t wanted, const char* what) {
    return {ErrorCode::BadInput,
            "size_mismatch: " + std::to_string(given) + " " + what + " for " +
                std::to_string(wanted) + " points",
            "points"};
}

Error singular(std::string where) {
    return {ErrorCode::BadInput,
            "singular_system: the data do not determine the surface; use more smoothing, more data "
            "or fewer vertices",
            std::move(where)};
}

/// A basis of the polynomials that an energy does not see.
std::vector<Coefficients> unseen_polynomials(const Space& space, Energy energy) {
    const mesh::Triangulation& mesh = space.mesh;
    double size = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        size = std::max({size, std::abs(mesh.x[v]), std::abs(mesh.y[v])});
    const double s = 1 / size;
    std::vector<TangentPlanes> planes(energy == Energy::ThinPlate ? 3 : 6);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const Vec2 p = s * mesh.vertex(v);
        const TangentPlanes basis{{1, {}},
                                  {p.x, {s, 0}},
                                  {p.y, {0, s}},
                                  {p.x * p.x, {2 * s * p.x, 0}},
                                  {p.x * p.y, {s * p.y, s * p.x}},
                                  {p.y * p.y, {0, 2 * s * p.y}}};
        for (std::size_t i = 0; i < planes.size(); ++i) planes[i].push_back(basis[i]);
    }
    std::vector<Coefficients> polynomials;
    for (const TangentPlanes& polynomial : planes)
        polynomials.push_back(coefficients(space, polynomial));
    return polynomials;
}

}  // namespace

struct LeastSquares::State {
    State(const Space& its_space, const DataSites& data, Energy energy)
        : space(its_space),
          sites(its_space, data),
          normal(sites.normal_matrix(energy == Energy::ThinPlate
                                         ? mesh::vertex_neighbours(space.mesh)
                                         : jump_coupling(space.mesh))),
          smoothness(energy == Energy::ThinPlate ? thin_plate_matrix(space) : jump_matrix(space)),
          unseen(unseen_polynomials(space, energy)) {
        for (Index t = 0; t < space.mesh.triangle_count(); ++t) {
            const auto [a, b, c] = space.mesh.corners(t);
            area += 0.5 * cross(b - a, c - a);
        }
        for (std::size_t k = 0; k < sites.size(); ++k) used += sites.weight(k) > 0;
        const std::size_t n = unseen.size();
        std::vector<double> products(n * n);
        for (std::size_t i = 0; i < n; ++i) {
            const Coefficients image = normal.times(unseen[i]);
            for (std::size_t j = 0; j < n; ++j)
                products[n * i + j] = inner_product(image, unseen[j]);
        }
        unseen_system = SmallCholesky::factor(std::move(products), n, kDegenerate);
    }

    /// Factors the normal matrix with smoothing.
    [[nodiscard]] Status factor(double smoothing, Solver& solver) const {
        BlockMatrix sum = normal;
        const double factor = smoothing * area * sites.total_weight();
        for (std::size_t k = 0; k < sum.block.size(); ++k)
            for (std::size_t i = 0; i < 9; ++i) sum.block[k][i] += factor * smoothness.block[k][i];
        std::optional<Index> lost = solver.factor(sum);
        // Smoothing determines everything, but thin triangles lose it to rounding.
        if (lost && smoothing > 0) lost = solver.factor(sum, kShift);
        if (lost) return singular("vertex " + std::to_string(*lost));
        return {};
    }

    /// The values seen through the B-splines.
    [[nodiscard]] Coefficients seen(std::span<const double> values) const {
        std::vector<double> factors(values.begin(), values.end());
        for (std::size_t k = 0; k < factors.size(); ++k) factors[k] *= sites.weight(k);
        return std::move(sites.adjoint(factors, 1)[0]);
    }

    /// The polynomial nearest to the data, and what is left of them, seen through the B-splines:
    /// where nothing determines the spline, it becomes that polynomial.
    struct Target {
        Coefficients polynomial;
        Coefficients rest;
    };
    /// Requires: unseen_system.
    [[nodiscard]] Target target(std::span<const double> values) const {
        const Coefficients products = seen(values);
        std::vector<double> weights;
        for (const Coefficients& polynomial : unseen)
            weights.push_back(inner_product(products, polynomial));
        unseen_system->solve(weights.data());
        Target target{Coefficients(normal.rows()), {}};
        for (std::size_t i = 0; i < unseen.size(); ++i)
            add(weights[i], unseen[i], target.polynomial);
        std::vector<double> rest(values.size());
        sites.evaluate(target.polynomial, rest);
        for (std::size_t k = 0; k < rest.size(); ++k) rest[k] = values[k] - rest[k];
        target.rest = seen(rest);
        return target;
    }

    /// Random signs times the roots of the weights, seen through the B-splines.
    [[nodiscard]] std::vector<Coefficients> probes() const {
        std::vector<double> factors(kProbes * sites.size());
        for (std::size_t k = 0; k < sites.size(); ++k) {
            const double root = std::sqrt(sites.weight(k));
            const std::uint64_t bits = scrambled(k);
            for (std::size_t s = 0; s < kProbes; ++s)
                factors[kProbes * k + s] = (bits >> s & 1) != 0 ? root : -root;
        }
        return sites.adjoint(factors, kProbes);
    }

    [[nodiscard]] std::vector<Target> targets(Components components) const {
        std::vector<Target> targets;
        for (const auto& values : components) targets.push_back(target(values));
        return targets;
    }

    [[nodiscard]] FitReport measured(Components components,
                                     const std::vector<Coefficients>& splines) const {
        FitReport report;
        double squares = 0;
        std::vector<double> at(sites.size());
        for (std::size_t m = 0; m < components.size(); ++m) {
            sites.evaluate(splines[m], at);
            for (std::size_t k = 0; k < at.size(); ++k) {
                const double off = std::abs(at[k] - components[m][k]);
                const double weight = sites.weight(k);
                squares += weight * off * off;
                if (weight > 0 && off > report.max_error) {
                    report.max_error = off;
                    report.worst = k;
                }
            }
        }
        report.rms_error =
            std::sqrt(squares / (sites.total_weight() * static_cast<double>(components.size())));
        return report;
    }

    [[nodiscard]] FittedSplines solved(const Solver& solver, Components components,
                                       const std::vector<Target>& targets) const {
        FittedSplines fitted;
        for (const Target& target : targets) {
            fitted.components.push_back(solver.solve(target.rest));
            add(1, target.polynomial, fitted.components.back());
        }
        fitted.report = measured(components, fitted.components);
        return fitted;
    }

    /// Generalised cross validation: how far off the fit is at data left out, as a mean square.
    [[nodiscard]] double score(const Solver& solver, const FitReport& report,
                               const std::vector<Coefficients>& probes) const {
        double trace = 0;
        for (const Coefficients& seen : probes) trace += inner_product(seen, solver.solve(seen));
        const double free = 1 - trace / static_cast<double>(kProbes * used);
        if (!(free > 0)) return std::numeric_limits<double>::infinity();
        return report.rms_error * report.rms_error / (free * free);
    }

    [[nodiscard]] Result<FittedSplines> fit(Components components, double smoothing) const {
        Solver solver(normal);
        RELIEF_CHECK(factor(smoothing, solver));
        FittedSplines fitted = solved(solver, components, targets(components));
        fitted.report.smoothing = smoothing;
        return fitted;
    }

    /// The power of ten with the least score.
    [[nodiscard]] Result<FittedSplines> validated(Components components) const {
        const std::vector<Coefficients> signs = probes();
        const std::vector<Target> wanted = targets(components);
        constexpr auto kTrials = static_cast<std::size_t>(kMostPower - kLeastPower + 1);
        std::array<double, kTrials> smoothing{};
        double power = 1e-12;
        for (double& s : smoothing) {
            s = power;
            power *= 10;
        }
        std::array<double, kTrials> scores{};
        scores.fill(std::numeric_limits<double>::infinity());
        std::array<FittedSplines, kTrials> fits;
        // Two at a time: factors are the most memory there is.
        parallel_for(0, 2, 1, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t half = begin; half < end; ++half) {
                Solver solver(normal);
                for (auto k = static_cast<std::size_t>(half); k < kTrials; k += 2) {
                    if (!factor(smoothing[k], solver).ok()) continue;
                    fits[k] = solved(solver, components, wanted);
                    fits[k].report.smoothing = smoothing[k];
                    scores[k] = score(solver, fits[k].report, signs);
                }
            }
        });
        const auto best = std::min_element(scores.begin(), scores.end());
        FittedSplines& chosen = fits[static_cast<std::size_t>(best - scores.begin())];
        if (!std::isinf(*best) || !chosen.components.empty()) return std::move(chosen);
        return fit(components, smoothing.back());
    }

    const Space& space;
    SortedSites sites;
    BlockMatrix normal;
    BlockMatrix smoothness;
    std::vector<Coefficients> unseen;
    std::optional<SmallCholesky> unseen_system;  ///< none: the points do not determine them
    double area = 0;
    std::size_t used = 0;  ///< points of positive weight
};

Result<LeastSquares> LeastSquares::create(const Space& space, const DataSites& sites,
                                          Energy energy) {
    if (sites.triangles.size() != sites.points.size())
        return size_mismatch(sites.triangles.size(), sites.points.size(), "triangles");
    if (!sites.weights.empty() && sites.weights.size() != sites.points.size())
        return size_mismatch(sites.weights.size(), sites.points.size(), "weights");
    double most = sites.weights.empty() && !sites.points.empty() ? 1 : 0;
    for (std::size_t k = 0; k < sites.weights.size(); ++k) {
        const double w = sites.weights[k];
        if (!(w >= 0 && w <= kLargest))
            return Error{ErrorCode::InvalidArgument,
                         "invalid_weight: weights are numbers from 0 to 1e150",
                         "point " + std::to_string(k)};
        most = std::max(most, w);
    }
    if (most == 0)
        return Error{ErrorCode::BadInput, "no_data: there is no point with a positive weight",
                     "points"};
    return LeastSquares(std::make_unique<State>(space, sites, energy));
}

LeastSquares::LeastSquares(std::unique_ptr<State> state) : state_(std::move(state)) {}
LeastSquares::LeastSquares(LeastSquares&&) noexcept = default;
LeastSquares& LeastSquares::operator=(LeastSquares&&) noexcept = default;
LeastSquares::~LeastSquares() = default;

Result<FittedSpline> LeastSquares::fit(std::span<const double> values,
                                       std::optional<double> smoothing) const {
    RELIEF_TRY(FittedSplines fitted, fit(Components(&values, 1), smoothing));
    return FittedSpline{std::move(fitted.components[0]), fitted.report};
}

Result<FittedSplines> LeastSquares::fit(Components components,
                                        std::optional<double> smoothing) const {
    for (const auto& values : components) {
        if (values.size() != state_->sites.size())
            return size_mismatch(values.size(), state_->sites.size(), "values");
        for (std::size_t k = 0; k < values.size(); ++k)
            if (!(std::abs(values[k]) <= kLargest))
                return Error{ErrorCode::BadInput,
                             "non_finite_input: its value is not a number of at most 1e150; leave "
                             "the point out or correct it",
                             "point " + std::to_string(k)};
    }
    if (!state_->unseen_system) return singular("points");
    if (!smoothing) return state_->validated(components);
    if (!(*smoothing >= 0) || std::isinf(*smoothing))
        return Error{ErrorCode::InvalidArgument,
                     "invalid_parameter: smoothing is a number from 0 on", "smoothing"};
    return state_->fit(components, *smoothing);
}

void LeastSquares::evaluate(std::span<const Heights> spline, std::span<double> out) const {
    state_->sites.evaluate(spline, out);
}

}  // namespace relief::multires::ps
