#include "codec/mesh_measure.h"

#include <algorithm>
#include <cmath>

namespace relief::codec {

MeshMeasure::MeshMeasure(const PolygonMesh& mesh, const MeshPoints& points, const MeshOrder& order,
                         MeshDistance distance, const PolygonMesh* original)
    : points_(points), order_(order), distance_(distance), original_(original) {
    if (distance != MeshDistance::Surface) return;
    shape_ = {.vertices = mesh.vertices, .offsets = mesh.offsets, .corners = mesh.corners};
    tree_.emplace(mesh::fan_triangles(original ? *original : shape_));
}

MeshErrors MeshMeasure::operator()(const MeshPoints& decoded, std::int64_t samples) const {
    MeshErrors errors;
    for (std::size_t v = 0; v < decoded.size(); ++v) {
        const Vec3<double> off = decoded[v] - points_[v];
        errors.max = std::max(errors.max, dot(off, off));
        errors.square += dot(off, off);
    }
    errors.max = std::sqrt(errors.max);
    errors.rms = std::sqrt(errors.square / static_cast<double>(decoded.size()));
    if (distance_ == MeshDistance::Vertices) return errors;
    PolygonMesh other = shape_;
    for (std::size_t v = 0; v < decoded.size(); ++v)
        other.vertices[order_.vertices[v]] = {decoded[v].x, decoded[v].y, decoded[v].z};
    // Both have faces, without which there would be no distance.
    const mesh::SurfaceDistance distance =
        *mesh::surface_distance(original_ ? *original_ : shape_, *tree_, other, samples);
    errors.max = distance.largest();
    errors.rms = distance.rms();
    return errors;
}

}  // namespace relief::codec
