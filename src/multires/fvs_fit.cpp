#include <algorithm>
#include <cmath>
#include <numeric>

#include "multires/fvs_functionals.h"
#include "relief/multires/fvs_mesh_coding.h"

namespace relief::multires::fvs_mesh {

using mesh::Index;
using mesh::Quadrangulation;

namespace {

/// The samples of one quad: sums of w w^T and of w times the residual of the start, w being the
/// weights of the quad's 16 scaled unknowns.
struct ElementBlock {
    QuadFunctionals functionals;
    std::array<double, 256> matrix{};
    std::array<double, 16> right{};
};

struct PlacedSample {
    mesh::Place place;
    double value = 0;
};

double dot_product(const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// The normal equations (sum of w w^T + ridge) y = sum of w r for the change y of the scaled
/// unknowns.
class NormalEquations {
  public:
    NormalEquations(const Quadrangulation& mesh, const std::vector<PlacedSample>& samples,
                    const NodalData& start, double ridge)
        : ridge_(ridge), scale_(flat(nodal_units(mesh, 1))) {
        for (std::size_t k = 0; k < samples.size(); ++k) {
            const Index q = samples[k].place.quad;
            if (k == 0 || q != samples[k - 1].place.quad) begin_quad(mesh, q, start);
            add(samples[k]);
        }
    }

    [[nodiscard]] const std::vector<double>& scale() const { return scale_; }

    [[nodiscard]] std::vector<double> right() const {
        std::vector<double> sum(scale_.size());
        for (const ElementBlock& block : blocks_)
            for (int i = 0; i < 16; ++i) sum[block.functionals.id[i]] += block.right[i];
        return sum;
    }

    [[nodiscard]] std::vector<double> diagonal() const {
        std::vector<double> sum(scale_.size(), ridge_);
        for (const ElementBlock& block : blocks_)
            for (int i = 0; i < 16; ++i) sum[block.functionals.id[i]] += block.matrix[17 * i];
        return sum;
    }

    [[nodiscard]] std::vector<double> times(const std::vector<double>& y) const {
        std::vector<double> sum(y.size());
        for (std::size_t k = 0; k < y.size(); ++k) sum[k] = ridge_ * y[k];
        for (const ElementBlock& block : blocks_) {
            std::array<double, 16> local;
            for (int i = 0; i < 16; ++i) local[i] = y[block.functionals.id[i]];
            for (int i = 0; i < 16; ++i) {
                double row = 0;
                for (int j = 0; j < 16; ++j) row += block.matrix[16 * i + j] * local[j];
                sum[block.functionals.id[i]] += row;
            }
        }
        return sum;
    }

  private:
    void begin_quad(const Quadrangulation& mesh, Index q, const NodalData& start) {
        blocks_.push_back({quad_functionals(mesh, q)});
        element_.emplace(mesh.corners(q));
        start_ = element_->ordinates(quad_data(mesh, start, q));
    }

    void add(const PlacedSample& sample) {
        ElementBlock& block = blocks_.back();
        const Vec2 p = sample.place.point;
        const int triangle = element_->triangle_of(p);
        std::array<double, 16> w = element_->weights(triangle, p);
        for (int i = 0; i < 16; ++i)
            w[i] *= block.functionals.sign[i] * scale_[block.functionals.id[i]];
        const double residual = sample.value - element_->jet(start_, triangle, p).value;
        for (int i = 0; i < 16; ++i) {
            block.right[i] += w[i] * residual;
            for (int j = 0; j < 16; ++j) block.matrix[16 * i + j] += w[i] * w[j];
        }
    }

    double ridge_;
    std::vector<double> scale_;  ///< 1 for values, 1 / h for derivatives: unknown = scale * y
    std::vector<ElementBlock> blocks_;
    std::optional<spline::FvsElement> element_;
    spline::FvsOrdinates start_;
};

struct Solution {
    std::vector<double> y;
    int iterations = 0;
};

/// Preconditioned by the diagonal: derivatives, even times h, count less than values.
Solution conjugate_gradients(const NormalEquations& equations, const FitOptions& options) {
    const std::vector<double> diagonal = equations.diagonal();
    std::vector<double> residual = equations.right();
    const std::size_t n = residual.size();
    Solution solution{std::vector<double>(n), 0};
    std::vector<double> scaled(n);
    std::vector<double> direction(n);
    double energy = 0;
    double enough = 0;
    for (;; ++solution.iterations) {
        for (std::size_t k = 0; k < n; ++k) scaled[k] = residual[k] / diagonal[k];
        const double next = dot_product(residual, scaled);
        if (solution.iterations == 0) enough = options.reduction * options.reduction * next;
        if (!(next > enough) || solution.iterations >= options.iterations) return solution;
        const double turn = solution.iterations == 0 ? 0 : next / energy;
        for (std::size_t k = 0; k < n; ++k) direction[k] = scaled[k] + turn * direction[k];
        energy = next;
        const std::vector<double> image = equations.times(direction);
        const double step = energy / dot_product(direction, image);
        for (std::size_t k = 0; k < n; ++k) {
            solution.y[k] += step * direction[k];
            residual[k] -= step * image[k];
        }
    }
}

/// The samples in the order of their quads.
Result<std::vector<PlacedSample>> placed(const Hierarchy& hierarchy, int level,
                                         std::span<const Vec2> points,
                                         std::span<const double> values) {
    std::vector<PlacedSample> samples;
    samples.reserve(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
        const std::string name = "sample " + std::to_string(k);
        if (!(std::abs(values[k]) <= 1e150))
            return bad_data(
                "non_finite_data: its value is not finite or beyond 1e150; leave it "
                "out",
                name);
        const auto place = locate(hierarchy, level, points[k]);
        if (!place) return bad_data("outside_domain: no quad contains it; leave it out", name);
        samples.push_back({*place, values[k]});
    }
    std::stable_sort(samples.begin(), samples.end(),
                     [](const auto& a, const auto& b) { return a.place.quad < b.place.quad; });
    return samples;
}

}  // namespace

Result<Fit> fit(const Hierarchy& hierarchy, int level, std::span<const Vec2> points,
                std::span<const double> values, const NodalData& start, const FitOptions& options) {
    if (level < 0 || level > hierarchy.levels()) return bad_level(level, hierarchy.levels());
    const Quadrangulation& mesh = hierarchy.mesh(level);
    RELIEF_CHECK(check(mesh, start));
    if (points.size() != values.size())
        return bad_data("size_mismatch: every sample needs a point and a value");
    if (!(options.ridge > 0))
        return Error{ErrorCode::InvalidArgument,
                     "ridge_not_positive: without it unknowns far from all samples have no value",
                     ""};
    if (points.empty()) return bad_data("no_samples: there is nothing to fit; pass some");
    RELIEF_TRY(const auto samples, placed(hierarchy, level, points, values));
    const NormalEquations equations(mesh, samples, start, options.ridge);
    const Solution solution = conjugate_gradients(equations, options);
    std::vector<double> numbers = flat(start);
    for (std::size_t k = 0; k < numbers.size(); ++k)
        numbers[k] += equations.scale()[k] * solution.y[k];
    Fit result{nodal(mesh, numbers), solution.iterations, 0};
    RELIEF_CHECK(check(mesh, result.data));
    std::vector<spline::PlaneJet> jets(points.size());
    RELIEF_CHECK(evaluate(hierarchy, level, result.data, points, jets));
    for (std::size_t k = 0; k < values.size(); ++k)
        result.rms += (jets[k].value - values[k]) * (jets[k].value - values[k]);
    result.rms = std::sqrt(result.rms / static_cast<double>(values.size()));
    return result;
}

}  // namespace relief::multires::fvs_mesh
