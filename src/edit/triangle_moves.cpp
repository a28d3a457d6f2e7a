#include "edit/triangle_moves.h"

#include "relief/core/parallel.h"

namespace relief::edit {

using mesh::Index;
namespace ps = multires::ps;

namespace {

constexpr std::int64_t kGrain = 64;

}  // namespace

TriangleMoves::TriangleMoves(const ps::Hierarchy& hierarchy, std::vector<const CellMesh*> meshes,
                             std::size_t components)
    : PlaneMoves(hierarchy.levels()), hierarchy_(hierarchy), meshes_(std::move(meshes)) {
    for (const CellMesh* mesh : meshes_)
        added_.emplace_back(components, ps::Coefficients(mesh->vertices.size()));
}

/// A refined mesh has the old vertices, one for each triangle and two for each edge.
std::vector<Index> TriangleMoves::children(int level, const std::vector<Index>& parents) const {
    const CellMesh& coarse = *meshes_[static_cast<std::size_t>(level) + 1];
    const auto triangles = static_cast<Index>(coarse.vertices.size());
    const Index edges = triangles + static_cast<Index>(coarse.cells.size());
    std::vector<Index> found = parents;
    for (const Index t : coarse.cells_at(parents)) found.push_back(triangles + t);
    for (const Index e : coarse.edges_at(parents))
        found.insert(found.end(), {edges + 2 * e, edges + 2 * e + 1});
    return found;
}

TriangleMoves::Numbers TriangleMoves::own(int level, Index v) const {
    const VertexMove move = at(level, v);
    const TriangleCorners& control = hierarchy_.space(refined(level)).control[v];
    if (added(level).size() == 1) return {ps::heights(control, {move.delta.z, move.slope})};
    return {ps::heights(control, {move.delta.x, {}}), ps::heights(control, {move.delta.y, {}}),
            ps::heights(control, {move.delta.z, {}})};
}

TriangleMoves::Numbers TriangleMoves::numbers(int level, Index v) const {
    Numbers sum = own(level, v);
    const int from = refined(level) - 1;
    if (from < 0) return sum;
    const ps::StepRows rows = ps::step_rows(hierarchy_.space(from), hierarchy_.step(from), v);
    const Components& coarse = added(level + 1);
    for (std::size_t c = 0; c < coarse.size(); ++c)
        for (std::size_t k = 0; k < static_cast<std::size_t>(rows.count); ++k)
            for (std::size_t j = 0; j < 3; ++j)
                for (std::size_t l = 0; l < 3; ++l)
                    sum[c][j] += rows.block[k][j][l] * coarse[c][rows.vertex[k]][l];
    return sum;
}

std::vector<Index> TriangleMoves::update(int level, const std::vector<Index>& vertices) {
    std::vector<Numbers> fresh(vertices.size());
    parallel_for(0, static_cast<std::int64_t>(vertices.size()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (auto k = static_cast<std::size_t>(first);
                          k < static_cast<std::size_t>(last); ++k)
                         fresh[k] = numbers(level, vertices[k]);
                 });
    Components& kept = added_[static_cast<std::size_t>(level)];
    std::vector<Index> changed;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
        bool same = true;
        for (std::size_t c = 0; c < kept.size(); ++c) {
            ps::Heights& before = kept[c][vertices[k]];
            same = same && before == fresh[k][c];
            before = fresh[k][c];
        }
        if (!same) changed.push_back(vertices[k]);
    }
    return changed;
}

}  // namespace relief::edit
