#include "edit/quad_moves.h"

#include "edit/quad_spline.h"
#include "relief/core/parallel.h"

namespace relief::edit {

using mesh::Index;
using mesh::Quadrangulation;
namespace fvs_mesh = multires::fvs_mesh;

namespace {

constexpr std::int64_t kGrain = 64;
/// Of about 500 bytes each.
constexpr std::size_t kMostRules = std::size_t{1} << 18;

template <class T, class Function>
std::vector<T> computed(const std::vector<Index>& elements, Function&& fn) {
    std::vector<T> results(elements.size());
    parallel_for(0, static_cast<std::int64_t>(elements.size()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (auto k = static_cast<std::size_t>(first);
                          k < static_cast<std::size_t>(last); ++k)
                         results[k] = fn(elements[k]);
                 });
    return results;
}

}  // namespace

QuadMoves::QuadMoves(const fvs_mesh::Hierarchy& hierarchy, std::vector<const CellMesh*> meshes)
    : PlaneMoves(hierarchy.levels()), hierarchy_(hierarchy), meshes_(std::move(meshes)) {
    for (int level = 0; level <= hierarchy.levels(); ++level) {
        const std::vector<double> zeros(mesh(level).vertex_count());
        levels_.push_back({fvs_mesh::LocalInterpolation(mesh(level)),
                           {zeros, zeros, zeros, std::vector<double>(mesh(level).edge_count())},
                           std::vector<VertexQuadratic>(zeros.size()),
                           std::vector<fvs_mesh::QuadraticRule>(zeros.size())});
    }
}

/// A refined mesh has the old vertices, one for each edge and one for each quad.
std::vector<Index> QuadMoves::children(int level, const std::vector<Index>& parents) const {
    const CellMesh& coarse = *meshes_[static_cast<std::size_t>(level) + 1];
    const auto edges = static_cast<Index>(coarse.vertices.size());
    const Index quads = edges + static_cast<Index>(coarse.edges.size());
    std::vector<Index> found = parents;
    for (const Index e : coarse.edges_at(parents)) found.push_back(edges + e);
    for (const Index q : coarse.cells_at(parents)) found.push_back(quads + q);
    return found;
}

double QuadMoves::value(int level, Index v) const {
    const double own = at(level, v).delta.z;
    if (level == hierarchy_.levels()) return own;
    const Quadrangulation& coarse = mesh(level + 1);
    const QuadSpline below(coarse, added(level + 1), nullptr);
    const Index edges = coarse.vertex_count();
    const Index quads = edges + coarse.edge_count();
    spline::PlaneJet jet;
    const Vec2 place = mesh(level).vertex(v);
    if (v < edges)
        below.at_vertex(v, &jet);
    else if (v < quads)
        below.on_edge(v - edges, 0.5, &jet);
    else
        below.in_cell(v - quads, {&place, 1}, &jet);
    return jet.value + own;
}

std::vector<Index> QuadMoves::set_values(int level, const std::vector<Index>& vertices) {
    const auto fresh = computed<double>(vertices, [&](Index v) { return value(level, v); });
    std::vector<double>& values = levels_[static_cast<std::size_t>(level)].data.value;
    std::vector<Index> changed;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
        double& kept = values[vertices[k]];
        if (kept != fresh[k]) changed.push_back(vertices[k]);
        kept = fresh[k];
    }
    return changed;
}

void QuadMoves::keep_rules(Level& here, const std::vector<Index>& vertices) {
    std::vector<Index> missing;
    for (const Index v : vertices)
        if (kept_rules_ + missing.size() < kMostRules && here.rules[v].shares.empty())
            missing.push_back(v);
    auto rules =
        computed<fvs_mesh::QuadraticRule>(missing, [&](Index v) { return here.local.rule(v); });
    for (std::size_t k = 0; k < missing.size(); ++k) here.rules[missing[k]] = std::move(rules[k]);
    kept_rules_ += missing.size();
}

std::vector<Index> QuadMoves::set_quadratics(int level, const std::vector<Index>& vertices) {
    Level& here = levels_[static_cast<std::size_t>(level)];
    keep_rules(here, vertices);
    const std::vector<double>& values = here.data.value;
    const auto fresh = computed<VertexQuadratic>(vertices, [&](Index v) {
        const fvs_mesh::QuadraticRule& kept = here.rules[v];
        if (!kept.shares.empty()) return kept.apply(values, v);
        return here.local.rule(v).apply(values, v);
    });
    std::vector<Index> changed;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
        const Index v = vertices[k];
        if (!(here.quadratics[v] == fresh[k])) changed.push_back(v);
        here.quadratics[v] = fresh[k];
        here.data.dx[v] = fresh[k].gradient.x;
        here.data.dy[v] = fresh[k].gradient.y;
    }
    return changed;
}

std::vector<Index> QuadMoves::update(int level, const std::vector<Index>& vertices) {
    Level& here = levels_[static_cast<std::size_t>(level)];
    std::vector<Index> changed = set_values(level, vertices);
    if (changed.empty()) return changed;
    const CellMesh& cells = *meshes_[static_cast<std::size_t>(level)];
    const auto ring = [&](const std::vector<Index>& some) {
        return cells.corners_of(cells.cells_at(some));
    };
    changed = merged(changed, set_quadratics(level, ring(ring(changed))));
    const Quadrangulation& mesh = this->mesh(level);
    for (const Index e : cells.edges_at(changed)) {
        const auto [from, to] = mesh.edges[e];
        here.data.normal[e] = here.local.normal(e, here.quadratics[from], here.quadratics[to]);
    }
    return changed;
}

}  // namespace relief::edit
