#include "relief/multires/subdivide.h"

#include <algorithm>
#include <utility>

#include "relief/multires/subdivider.h"

namespace relief::multires {

MeshTags tags_of(const Sharpness& sharpness) {
    MeshTags tags;
    const auto sharp = [](double s) { return static_cast<std::uint8_t>(std::isinf(s)); };
    tags.sharp.resize(sharpness.edges.size());
    tags.corner.resize(sharpness.vertices.size());
    std::transform(sharpness.edges.begin(), sharpness.edges.end(), tags.sharp.begin(), sharp);
    std::transform(sharpness.vertices.begin(), sharpness.vertices.end(), tags.corner.begin(),
                   sharp);
    return tags;
}

template <class T>
Result<SubdividedMesh<T>> subdivide(SubdividedMesh<T> mesh, const MeshSpec& spec, int steps) {
    for (const auto& array : mesh.arrays)
        if (array.size() != mesh.mesh.vertex_count)
            return Error{ErrorCode::InvalidArgument,
                         "invalid_parameter: arrays need one element a vertex", "arrays"};
    if (steps == 0) return mesh;
    Subdivider subdivider;
    RELIEF_CHECK(subdivider.prepare(mesh.mesh, mesh.sharpness, spec, steps));
    for (auto& array : mesh.arrays) {
        std::vector<Vec3<T>> fine(subdivider.counts().vertices);
        subdivider.points<T>(array, fine);
        array = std::move(fine);
    }
    RELIEF_TRY(mesh::Topology finest, subdivider.finest());
    mesh.sharpness = subdivider.sharpness(finest);
    mesh.mesh = std::move(finest);
    return mesh;
}

template Result<SubdividedMesh<float>> subdivide(SubdividedMesh<float>, const MeshSpec&, int);
template Result<SubdividedMesh<double>> subdivide(SubdividedMesh<double>, const MeshSpec&, int);

}  // namespace relief::multires
