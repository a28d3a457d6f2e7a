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

struct Neighbour {
    Vec2 offset;
    double rise = 0;
};

/// The first `unknowns` (2: a plane, 5: a quadratic) of gradient and Hessian through the origin.
/// Distances are divided by their mean, so that pivots do not depend on units.
std::optional<VertexQuadratic> fit_through_origin(const std::vector<Neighbour>& neighbours,
                                                  std::size_t unknowns, double smallest_pivot) {
    double size = 0;
    for (const Neighbour& n : neighbours) size += length(n.offset);
    size /= static_cast<double>(neighbours.size());
    std::vector<double> normal(unknowns * unknowns);
    std::array<double, 5> x{};
    for (const Neighbour& n : neighbours) {
        const Vec2 d = (1 / size) * n.offset;
        const double weight = 1 / dot(d, d);
        const std::array<double, 5> row = {d.x, d.y, 0.5 * d.x * d.x, d.x * d.y, 0.5 * d.y * d.y};
        for (std::size_t i = 0; i < unknowns; ++i) {
            for (std::size_t j = 0; j <= i; ++j)
                normal[i * unknowns + j] += weight * row[i] * row[j];
            x[i] += weight * row[i] * n.rise;
        }
    }
    const auto cholesky = SmallCholesky::factor(std::move(normal), unknowns, smallest_pivot);
    if (!cholesky) return std::nullopt;
    cholesky->solve(x.data());
    const double squared = size * size;
    return VertexQuadratic{
        {x[0] / size, x[1] / size}, x[2] / squared, x[3] / squared, x[4] / squared};
}

std::vector<Neighbour> neighbours(const Quadrangulation& mesh, std::span<const double> values,
                                  Index v, const std::vector<Index>& vertices) {
    std::vector<Neighbour> list;
    list.reserve(vertices.size());
    for (const Index w : vertices)
        if (w != v) list.push_back({mesh.vertex(w) - mesh.vertex(v), values[w] - values[v]});
    return list;
}

}  // namespace

std::vector<Index> LocalInterpolation::ring(std::span<const Index> vertices) const {
    std::vector<Index> found;
    for (const Index v : vertices)
        for (const Index q : quads_.of(v))
            found.insert(found.end(), mesh_->quads[q].begin(), mesh_->quads[q].end());
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

VertexQuadratic LocalInterpolation::quadratic(std::span<const double> values, Index v) const {
    const std::vector<Index> first = ring({&v, 1});
    const std::vector<Neighbour> near = neighbours(*mesh_, values, v, first);
    if (const auto fit = fit_through_origin(near, 5, kDetermined)) return *fit;
    const std::vector<Neighbour> far = neighbours(*mesh_, values, v, ring(first));
    if (const auto fit = fit_through_origin(far, 5, kDetermined)) return *fit;
    return fit_through_origin(near, 2, kPlanePivot).value_or(VertexQuadratic{});
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
