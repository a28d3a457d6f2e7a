#include "relief/multires/mesh_frames.h"

#include <algorithm>

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;

constexpr double kNoNormal = 1e-12;
constexpr double kNoTangent = 1e-9;

/// What is known of the places that have a frame: the sum of cross products, the smallest
/// neighbour.
struct Around {
    Vec3<double> normal;
    Index neighbour = kNone;
};

MeshFrame frame_of(const Around& around, const Vec3<double>& here, const Vec3<double>* points) {
    MeshFrame frame;
    if (around.neighbour == kNone) return frame;
    Vec3<double> tangent = points[around.neighbour] - here;
    const double long_normal = length(around.normal);
    if (!(long_normal > kNoNormal * dot(tangent, tangent))) return frame;
    const Vec3<double> normal = 1 / long_normal * around.normal;
    const double whole = length(tangent);
    tangent -= dot(normal, tangent) * normal;
    const double rest = length(tangent);
    if (!(rest > kNoTangent * whole)) return frame;
    frame.normal = normal;
    frame.tangent = 1 / rest * tangent;
    frame.bitangent = cross(normal, frame.tangent);
    frame.size = std::sqrt(long_normal);
    return frame;
}

/// place(v): where vertex v has its frame, or kNone.
template <class PlaceOf>
std::vector<Around> look_around(const mesh::Topology& mesh, const Vec3<double>* points,
                                std::size_t count, PlaceOf place) {
    std::vector<Around> around(count);
    for (Index f = 0; f < mesh.face_count; ++f) {
        const auto corners = mesh.corners(f);
        Vec3<double> normal;
        for (std::size_t k = 1; k + 1 < corners.size(); ++k)
            normal += cross(points[corners[k]] - points[corners[0]],
                            points[corners[k + 1]] - points[corners[0]]);
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const Index at = place(corners[k]);
            if (at == kNone) continue;
            around[at].normal += normal;
            const Index next = corners[k + 1 == corners.size() ? 0 : k + 1];
            const Index prev = corners[k == 0 ? corners.size() - 1 : k - 1];
            around[at].neighbour = std::min(around[at].neighbour, std::min(next, prev));
        }
    }
    return around;
}

}  // namespace

std::vector<MeshFrame> frames(const mesh::Topology& mesh, const Vec3<double>* points, Index first) {
    const std::size_t count = mesh.vertex_count - first;
    const auto around =
        look_around(mesh, points, count, [&](Index v) { return v < first ? kNone : v - first; });
    std::vector<MeshFrame> result(count);
    for (std::size_t k = 0; k < count; ++k)
        result[k] = frame_of(around[k], points[first + k], points);
    return result;
}

std::vector<MeshFrame> frames(const mesh::Topology& mesh, const Vec3<double>* points,
                              std::span<const Index> vertices) {
    std::vector<Index> places(mesh.vertex_count, kNone);
    for (std::size_t k = 0; k < vertices.size(); ++k) places[vertices[k]] = static_cast<Index>(k);
    const auto around =
        look_around(mesh, points, vertices.size(), [&](Index v) { return places[v]; });
    std::vector<MeshFrame> result(vertices.size());
    for (std::size_t k = 0; k < vertices.size(); ++k)
        result[k] = frame_of(around[k], points[vertices[k]], points);
    return result;
}

}  // namespace relief::multires
