#include <algorithm>

#include "relief/mesh/repair.h"

namespace relief::mesh {

namespace {

/// The elements of a list at some places.
template <class T>
std::vector<T> gathered(const std::vector<T>& list, const std::vector<Index>& places) {
    std::vector<T> result;
    result.reserve(places.size());
    for (const Index k : places) result.push_back(list[k]);
    return result;
}

MeshAttribute followed(const MeshAttribute& attribute, const Repaired& repaired) {
    MeshAttribute result = attribute;
    if (attribute.face_varying()) {
        result.corners = gathered(attribute.corners, repaired.corners);
        return result;
    }
    result.values.clear();
    for (const Index v : repaired.vertices) {
        const double* element = attribute.element(v);
        result.values.insert(result.values.end(), element, element + attribute.components);
    }
    return result;
}

/// An edge of the old mesh and one of the new mesh that comes from it.
struct EdgeCopy {
    std::array<Index, 2> old;  ///< the smaller end first
    std::array<Index, 2> now;  ///< the copies of these ends

    friend auto operator<=>(const EdgeCopy&, const EdgeCopy&) = default;
};

std::vector<EdgeCopy> edge_copies(const Repaired& repaired) {
    std::vector<EdgeCopy> copies;
    copies.reserve(repaired.corners.size());
    for (std::size_t f = 0; f < repaired.faces.size(); ++f) {
        const auto face = repaired.faces[f];
        for (std::size_t k = 0; k < face.size(); ++k) {
            Index a = face[k];
            Index b = face[k + 1 < face.size() ? k + 1 : 0];
            if (repaired.vertices[a] > repaired.vertices[b]) std::swap(a, b);
            copies.push_back({{repaired.vertices[a], repaired.vertices[b]}, {a, b}});
        }
    }
    std::sort(copies.begin(), copies.end());
    copies.erase(std::unique(copies.begin(), copies.end()), copies.end());
    return copies;
}

std::vector<CreaseEdge> followed(const std::vector<CreaseEdge>& creases, const Repaired& repaired) {
    if (creases.empty()) return {};
    const std::vector<EdgeCopy> copies = edge_copies(repaired);
    std::vector<CreaseEdge> result;
    for (const CreaseEdge& crease : creases) {
        const bool swapped = crease.a > crease.b;
        const auto low = static_cast<Index>(swapped ? crease.b : crease.a);
        const auto high = static_cast<Index>(swapped ? crease.a : crease.b);
        const EdgeCopy wanted{{low, high}, {0, 0}};
        for (auto copy = std::lower_bound(copies.begin(), copies.end(), wanted);
             copy != copies.end() && copy->old == wanted.old; ++copy)
            result.push_back({static_cast<std::int32_t>(copy->now[swapped ? 1 : 0]),
                              static_cast<std::int32_t>(copy->now[swapped ? 0 : 1]),
                              crease.sharpness});
    }
    return result;
}

std::vector<SharpVertex> followed(const std::vector<SharpVertex>& sharp, const Repaired& repaired) {
    if (sharp.empty()) return {};
    std::vector<std::array<Index, 2>> copies;  // old vertex, new vertex
    for (Index v = 0; v < repaired.vertex_count; ++v) copies.push_back({repaired.vertices[v], v});
    std::sort(copies.begin(), copies.end());
    std::vector<SharpVertex> result;
    for (const SharpVertex& vertex : sharp) {
        const auto old = static_cast<Index>(vertex.vertex);
        for (auto copy = std::lower_bound(copies.begin(), copies.end(), std::array{old, Index{0}});
             copy != copies.end() && (*copy)[0] == old; ++copy)
            result.push_back({static_cast<std::int32_t>((*copy)[1]), vertex.sharpness});
    }
    return result;
}

}  // namespace

FaceList faces_of(const PolygonMesh& mesh) {
    return {mesh.offsets, {mesh.corners.begin(), mesh.corners.end()}};
}

RepairedMesh repair(const PolygonMesh& mesh) {
    const Repaired repaired = repair(faces_of(mesh), static_cast<Index>(mesh.vertices.size()));
    PolygonMesh result;
    result.vertices = gathered(mesh.vertices, repaired.vertices);
    result.offsets = repaired.faces.offsets;
    result.corners.assign(repaired.faces.corners.begin(), repaired.faces.corners.end());
    for (const MeshAttribute& attribute : mesh.attributes)
        result.attributes.push_back(followed(attribute, repaired));
    for (const FaceLabels& labels : mesh.labels)
        result.labels.push_back(
            {labels.keyword, labels.names, gathered(labels.of_face, repaired.sources)});
    result.libraries = mesh.libraries;
    result.creases = followed(mesh.creases, repaired);
    result.sharp_vertices = followed(mesh.sharp_vertices, repaired);
    return {std::move(result), repaired.counts};
}

}  // namespace relief::mesh
