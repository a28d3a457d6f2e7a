#include "relief/multires/mesh_pyramid.h"

#include <cmath>
#include <string>

namespace relief::multires {

using mesh::Index;

Result<MeshPyramid> MeshPyramid::analyse(const mesh::Topology& mesh,
                                         std::span<const Vec3<double>> points, const MeshTags& tags,
                                         MeshScheme scheme, int most,
                                         const MeshTransform& transform) {
    for (std::size_t v = 0; v < points.size(); ++v)
        if (!std::isfinite(points[v].x) || !std::isfinite(points[v].y) ||
            !std::isfinite(points[v].z))
            return Error{ErrorCode::BadInput, "non_finite_vertex: a coordinate is not a number",
                         "vertex " + std::to_string(v)};
    RELIEF_TRY(MeshOrigin origin, origin_of(mesh, points, tags, scheme, most));
    RELIEF_TRY(mesh::Topology base,
               mesh::build(mesh::faces_of(origin.base), origin.base.vertex_count));
    RELIEF_TRY(MeshHierarchy hierarchy,
               MeshHierarchy::create(std::move(base), origin.tags, origin.spec, origin.steps));
    MeshPyramid pyramid;
    pyramid.hierarchy_ = std::make_unique<MeshHierarchy>(std::move(hierarchy));
    RELIEF_TRY(MeshMaps maps, MeshMaps::create(*pyramid.hierarchy_, transform));
    pyramid.maps_ = std::make_unique<MeshMaps>(std::move(maps));

    const mesh::Topology& finest = pyramid.topology(0);
    pyramid.numbers_.resize(finest.vertex_count);
    for (Index h = 0; h < finest.half_edge_count(); ++h)
        pyramid.numbers_[finest.origin[h]] = mesh.origin[origin.half_edge(h)];
    pyramid.coefficients_.reserve(points.size());
    for (const Index v : pyramid.numbers_) pyramid.coefficients_.push_back(points[v]);
    pyramid.maps_->analyse(pyramid.coefficients_.data(), pyramid.residuals_);
    return pyramid;
}

std::span<Vec3<double>> MeshPyramid::band(int level) {
    const std::size_t first = level == levels() ? 0 : hierarchy_->vertices(levels() - level - 1);
    return std::span(coefficients_).subspan(first, hierarchy_->vertices(levels() - level) - first);
}

std::vector<Vec3<double>> MeshPyramid::synthesise(int level) const {
    const int depth = levels() - level;
    std::vector<Vec3<double>> points(
        coefficients_.begin(),
        coefficients_.begin() + static_cast<std::ptrdiff_t>(hierarchy_->vertices(depth)));
    maps_->synthesise(0, depth, points.data(), residuals_);
    return points;
}

}  // namespace relief::multires
