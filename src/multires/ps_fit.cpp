#include "relief/multires/ps_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "multires/ps_normal.h"
#include "multires/small_cholesky.h"
#include "relief/core/parallel.h"

namespace relief::multires::ps {

using mesh::Index;

namespace {

constexpr double kLargest = 1e150;
/// Random sign vectors that estimate the trace of the influence matrix.
constexpr std::size_t kProbes = 10;
constexpr double kDegenerate = 1e-12;
constexpr int kLeastPower = -12;
constexpr int kMostPower = -3;

/// The k-th of a fixed sequence of random numbers.
std::uint64_t scrambled(std::uint64_t k) {
    std::uint64_t z = (k + 1) * 0x9E3779B97F4A7C15;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return z ^ (z >> 31);
}

double inner_product(std::span<const Column3> a, std::span<const Column3> b) {
    double sum = 0;
    for (std::size_t v = 0; v < a.size(); ++v)
        sum += a[v][0] * b[v][0] + a[v][1] * b[v][1] + a[v][2] * b[v][2];
    return sum;
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

/// Whether points determine the polynomials that an energy does not see: not all on a line, or on a
/// conic. Coordinates are relative to a point near them.
bool determine(const DataSites& sites, Vec2 origin, Energy energy) {
    const std::size_t n = energy == Energy::ThinPlate ? 3 : 6;
    double size = 0;
    for (const Vec2& p : sites.points) {
        const Vec2 d = p - origin;
        size = std::max({size, std::abs(d.x), std::abs(d.y)});
    }
    std::vector<double> moments(n * n, 0);
    for (std::size_t k = 0; k < sites.points.size(); ++k) {
        if (!sites.weights.empty() && !(sites.weights[k] > 0)) continue;
        const Vec2 d = 1 / size * (sites.points[k] - origin);
        const std::array<double, 6> row{1, d.x, d.y, d.x * d.x, d.x * d.y, d.y * d.y};
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j <= i; ++j) moments[n * i + j] += row[i] * row[j];
    }
    return SmallCholesky::factor(std::move(moments), n, kDegenerate).has_value();
}

}  // namespace

struct LeastSquares::State {
    State(const Space& its_space, const DataSites& data, Energy energy)
        : space(its_space),
          sites(its_space, data),
          graph(coupling(its_space.mesh, energy)),
          normal(sites.normal_matrix(graph)),
          smoothness(energy_matrix(its_space, graph, energy)),
          determined(determine(data, its_space.mesh.origin, energy)) {
        const auto& mesh = space.mesh;
        for (Index t = 0; t < mesh.triangle_count(); ++t) {
            const auto [a, b, c] = mesh.corners(t);
            area += 0.5 * cross(b - a, c - a);
        }
        std::vector<Vec2> points;
        for (Index v = 0; v < mesh.vertex_count(); ++v) points.push_back(mesh.vertex(v));
        order = nested_dissection(points, graph_of(graph));
        for (std::size_t k = 0; k < sites.size(); ++k) used += sites.weight(k) > 0;
    }

    /// The factors of the normal matrix, divided by the sum of weights.
    [[nodiscard]] Result<BlockCholesky> factors(double smoothing) const {
        const GraphView view = graph_of(graph);
        BlockCholesky solver(view, order);
        const NormalMatrix sum =
            combined(normal, smoothing * area * sites.total_weight(), smoothness);
        // With smoothing the system is positive definite wherever the mesh is fine enough for
        // the data; what thin triangles lose to rounding is harmless.
        const LostPivots lost = smoothing > 0 ? LostPivots::Raise : LostPivots::Refuse;
        const std::size_t bad = solver.factor(view, sum.diagonal, sum.off_diagonal, lost);
        if (bad < solver.size()) return singular("vertex " + std::to_string(bad));
        return solver;
    }

    [[nodiscard]] std::vector<Column3> right_side(std::span<const double> values) const {
        std::vector<double> factor(values.begin(), values.end());
        for (std::size_t k = 0; k < factor.size(); ++k) factor[k] *= sites.weight(k);
        std::vector<std::vector<Column3>> sums(1);
        sites.adjoint(factor, 1, sums);
        return std::move(sums[0]);
    }

    /// Random signs times the roots of the weights, seen through the B-splines.
    [[nodiscard]] std::vector<std::vector<Column3>> probes() const {
        std::vector<double> factor(kProbes * sites.size());
        for (std::size_t k = 0; k < sites.size(); ++k) {
            const double root = std::sqrt(sites.weight(k));
            const std::uint64_t bits = scrambled(k);
            for (std::size_t s = 0; s < kProbes; ++s)
                factor[kProbes * k + s] = (bits >> s & 1) != 0 ? root : -root;
        }
        std::vector<std::vector<Column3>> sums(kProbes);
        sites.adjoint(factor, kProbes, sums);
        return sums;
    }

    [[nodiscard]] FitReport measured(std::span<const double> values,
                                     std::span<const Heights> spline) const {
        std::vector<double> at(values.size());
        sites.evaluate(spline, at);
        FitReport report;
        double squares = 0;
        for (std::size_t k = 0; k < at.size(); ++k) {
            const double off = std::abs(at[k] - values[k]);
            const double weight = sites.weight(k);
            squares += weight * off * off;
            if (weight > 0 && off > report.max_error) {
                report.max_error = off;
                report.worst = k;
            }
        }
        report.rms_error = std::sqrt(squares / sites.total_weight());
        return report;
    }

    [[nodiscard]] FittedSpline solved(const BlockCholesky& solver, std::span<const double> values,
                                      const std::vector<Column3>& right) const {
        FittedSpline fitted{right, {}};
        solver.solve(fitted.spline);
        fitted.report = measured(values, fitted.spline);
        return fitted;
    }

    /// Generalised cross validation: how far off the fit is at data left out, as a mean square.
    [[nodiscard]] double score(const BlockCholesky& solver, const FitReport& report,
                               const std::vector<std::vector<Column3>>& probe) const {
        double trace = 0;
        for (const auto& seen : probe) {
            std::vector<Column3> x = seen;
            solver.solve(x);
            trace += inner_product(seen, x);
        }
        const double free = 1 - trace / static_cast<double>(kProbes * used);
        if (!(free > 0)) return std::numeric_limits<double>::infinity();
        return report.rms_error * report.rms_error / (free * free);
    }

    [[nodiscard]] Result<FittedSpline> fit(std::span<const double> values, double smoothing) const {
        RELIEF_TRY(const BlockCholesky solver, factors(smoothing));
        FittedSpline fitted = solved(solver, values, right_side(values));
        fitted.report.smoothing = smoothing;
        return fitted;
    }

    /// The power of ten with the least score.
    [[nodiscard]] Result<FittedSpline> validated(std::span<const double> values) const {
        const auto probe = probes();
        const std::vector<Column3> right = right_side(values);
        constexpr auto kTrials = static_cast<std::size_t>(kMostPower - kLeastPower + 1);
        std::array<double, kTrials> scores{};
        std::array<FittedSpline, kTrials> fits;
        std::array<double, kTrials> smoothing{};
        double power = 1e-12;
        for (double& s : smoothing) {
            s = power;
            power *= 10;
        }
        // Two at a time: factors are the most memory there is.
        for (std::size_t k = 0; k < kTrials; k += 2)
            parallel_for(0, 2, 1, [&](std::int64_t begin, std::int64_t end) {
                for (std::int64_t j = begin; j < end; ++j) {
                    const std::size_t trial = k + static_cast<std::size_t>(j);
                    scores[trial] = std::numeric_limits<double>::infinity();
                    const auto solver = factors(smoothing[trial]);
                    if (!solver.ok()) continue;
                    fits[trial] = solved(*solver, values, right);
                    fits[trial].report.smoothing = smoothing[trial];
                    scores[trial] = score(*solver, fits[trial].report, probe);
                }
            });
        const auto best = std::min_element(scores.begin(), scores.end());
        FittedSpline& chosen = fits[static_cast<std::size_t>(best - scores.begin())];
        if (!std::isinf(*best) || !chosen.spline.empty()) return std::move(chosen);
        return fit(values, smoothing.back());
    }

    const Space& space;
    SortedSites sites;
    mesh::VertexStars graph;
    NormalMatrix normal;
    NormalMatrix smoothness;
    bool determined;
    double area = 0;
    std::size_t used = 0;  ///< points of positive weight
    std::vector<Index> order;
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
    if (values.size() != state_->sites.size())
        return size_mismatch(values.size(), state_->sites.size(), "values");
    for (std::size_t k = 0; k < values.size(); ++k)
        if (!(std::abs(values[k]) <= kLargest))
            return Error{ErrorCode::BadInput,
                         "non_finite_input: its value is not a number of at most 1e150; leave the "
                         "point out or correct it",
                         "point " + std::to_string(k)};
    if (!state_->determined && smoothing != 0.0) return singular("points");
    if (!smoothing) return state_->validated(values);
    if (!(*smoothing >= 0) || std::isinf(*smoothing))
        return Error{ErrorCode::InvalidArgument,
                     "invalid_parameter: smoothing is a number from 0 on", "smoothing"};
    return state_->fit(values, *smoothing);
}

void LeastSquares::evaluate(std::span<const Heights> spline, std::span<double> out) const {
    state_->sites.evaluate(spline, out);
}

}  // namespace relief::multires::ps
