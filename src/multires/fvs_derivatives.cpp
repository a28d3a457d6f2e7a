#include <algorithm>
#include <array>
#include <cmath>

#include "multires/fvs_functionals.h"
#include "multires/small_cholesky.h"
#include "relief/core/parallel.h"

namespace relief::multires::fvs_mesh {

using mesh::Index;
using mesh::Quadrangulation;

namespace {

constexpr std::int64_t kGrain = 256;
constexpr double kDetermined = 1e-3;  ///< smallest pivot of a fit that determines a quadratic
constexpr double kPlanePivot = 1e-14;

/// Least squares of the first `unknowns` (2: a plane, 5: a quadratic) of gradient and Hessian
/// through the origin. Distances are divided by their mean, so that pivots do not depend on units.
class OriginFit {
  public:
    static std::optional<OriginFit> create(const std::vector<Vec2>& offsets, std::size_t unknowns,
                                           double smallest_pivot) {
        double size = 0;
        for (const Vec2 offset : offsets) size += length(offset);
        size /= static_cast<double>(offsets.size());
        std::vector<double> normal(unknowns * unknowns);
        for (const Vec2 offset : offsets) {
            const Vec2 d = (1 / size) * offset;
            const double weight = 1 / dot(d, d);
            const std::array<double, 5> row = row_of(d);
            for (std::size_t i = 0; i < unknowns; ++i)
                for (std::size_t j = 0; j <= i; ++j)
                    normal[i * unknowns + j] += weight * row[i] * row[j];
        }
        auto cholesky = SmallCholesky::factor(std::move(normal), unknowns, smallest_pivot);
        if (!cholesky) return std::nullopt;
        return OriginFit(size, unknowns, *std::move(cholesky));
    }

    /// Adds a point to the right-hand side.
    void add(Vec2 offset, double rise, std::array<double, 5>& x) const {
        const Vec2 d = (1 / size_) * offset;
        const double weight = 1 / dot(d, d);
        const std::array<double, 5> row = row_of(d);
        for (std::size_t i = 0; i < unknowns_; ++i) x[i] += weight * row[i] * rise;
    }

    [[nodiscard]] VertexQuadratic solved(std::array<double, 5> x) const {
        cholesky_.solve(x.data());
        const double squared = size_ * size_;
        return {{x[0] / size_, x[1] / size_}, x[2] / squared, x[3] / squared, x[4] / squared};
    }

  private:
    OriginFit(double size, std::size_t unknowns, SmallCholesky cholesky)
        : size_(size), unknowns_(unknowns), cholesky_(std::move(cholesky)) {}
    static std::array<double, 5> row_of(Vec2 d) {
        return {d.x, d.y, 0.5 * d.x * d.x, d.x * d.y, 0.5 * d.y * d.y};
    }

    double size_;
    std::size_t unknowns_;
    SmallCholesky cholesky_;
};

/// All vertices of the quads at the given ones, ascending: of one vertex its 1-ring.
std::vector<Index> ring(const Quadrangulation& mesh, const mesh::VertexQuads& quads,
                        std::span<const Index> vertices) {
    std::vector<Index> found;
    for (const Index v : vertices)
        for (const Index q : quads.of(v))
            found.insert(found.end(), mesh.quads[q].begin(), mesh.quads[q].end());
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

/// The vertices around one to which its quadratic is fitted, and the fit; none if they are
/// collinear with it.
struct VertexFit {
    std::vector<Index> around;
    std::vector<Vec2> offsets;
    std::optional<OriginFit> fit;

    VertexFit(const Quadrangulation& mesh, const mesh::VertexQuads& quads, Index v) {
        const std::vector<Index> first = ring(mesh, quads, {&v, 1});
        take(mesh, first, v);
        if ((fit = OriginFit::create(offsets, 5, kDetermined))) return;
        take(mesh, ring(mesh, quads, first), v);
        if ((fit = OriginFit::create(offsets, 5, kDetermined))) return;
        take(mesh, first, v);
        fit = OriginFit::create(offsets, 2, kPlanePivot);
    }

  private:
    void take(const Quadrangulation& mesh, const std::vector<Index>& vertices, Index v) {
        around.clear();
        offsets.clear();
        for (const Index w : vertices) {
            if (w == v) continue;
            around.push_back(w);
            offsets.push_back(mesh.vertex(w) - mesh.vertex(v));
        }
    }
};

}  // namespace

VertexQuadratic LocalInterpolation::quadratic(std::span<const double> values, Index v) const {
    const VertexFit known(*mesh_, quads_, v);
    if (!known.fit) return {};
    std::array<double, 5> sum{};
    for (std::size_t k = 0; k < known.around.size(); ++k)
        known.fit->add(known.offsets[k], values[known.around[k]] - values[v], sum);
    return known.fit->solved(sum);
}

QuadraticRule LocalInterpolation::rule(Index v) const {
    const VertexFit known(*mesh_, quads_, v);
    QuadraticRule rule;
    if (!known.fit) return rule;
    rule.shares.reserve(known.around.size());
    for (std::size_t k = 0; k < known.around.size(); ++k) {
        std::array<double, 5> one{};
        known.fit->add(known.offsets[k], 1, one);
        rule.shares.push_back({known.around[k], known.fit->solved(one)});
    }
    return rule;
}

VertexQuadratic QuadraticRule::apply(std::span<const double> values, Index v) const {
    VertexQuadratic sum;
    for (const Share& share : shares) {
        const double rise = values[share.vertex] - values[v];
        sum.gradient = sum.gradient + rise * share.quadratic.gradient;
        sum.xx += rise * share.quadratic.xx;
        sum.xy += rise * share.quadratic.xy;
        sum.yy += rise * share.quadratic.yy;
    }
    return sum;
}

double LocalInterpolation::normal(Index e, const VertexQuadratic& from,
                                  const VertexQuadratic& to) const {
    const Vec2 half = 0.5 * mesh_->edge_vector(e);
    const Vec2 gradient = midpoint(from.gradient_at(half), to.gradient_at(-1.0 * half));
    return dot(gradient, turned(unit(mesh_->edge_vector(e))));
}

Result<NodalData> interpolate_values(const Quadrangulation& mesh, std::span<const double> values) {
    NodalData data = make_nodal<double>(mesh);
    data.value.assign(values.begin(), values.end());
    RELIEF_CHECK(check(mesh, data));
    const LocalInterpolation local(mesh);
    std::vector<VertexQuadratic> fits(values.size());
    parallel_for(0, static_cast<std::int64_t>(values.size()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (std::int64_t v = first; v < last; ++v)
                         fits[v] = local.quadratic(values, static_cast<Index>(v));
                 });
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        data.dx[v] = fits[v].gradient.x;
        data.dy[v] = fits[v].gradient.y;
    }
    for (Index e = 0; e < mesh.edge_count(); ++e)
        data.normal[e] = local.normal(e, fits[mesh.edges[e][0]], fits[mesh.edges[e][1]]);
    RELIEF_CHECK(check(mesh, data));
    return data;
}

}  // namespace relief::multires::fvs_mesh
