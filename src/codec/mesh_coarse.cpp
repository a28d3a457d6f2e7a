#include "codec/mesh_coarse.h"

#include <algorithm>
#include <cstddef>

namespace relief::codec {

namespace {

using mesh::Index;

/// For each half-edge of depth `depth` the corner of the finest mesh that it begins at.
std::vector<Index> finest_corners(const MeshOrder& order, const MeshHierarchy& hierarchy,
                                  int depth) {
    const auto sides = static_cast<Index>(hierarchy.topology(hierarchy.steps()).sides);
    std::vector<Index> corners;
    for (Index h = 0; h < hierarchy.topology(depth).half_edge_count(); ++h) {
        Index fine = h;
        for (int step = depth; step < hierarchy.steps(); ++step)
            fine = mesh::halves(hierarchy.topology(step), hierarchy.rules(step).split, fine)[0];
        const Index first = order.corners[fine / sides];
        corners.push_back(first / sides * sides + (first % sides + fine % sides) % sides);
    }
    return corners;
}

MeshAttribute of_vertices(const MeshAttribute& fine, const MeshOrder& order, std::size_t count) {
    MeshAttribute coarse{fine.name, fine.components, fine.type, {}, {}};
    for (std::size_t v = 0; v < count; ++v) {
        const double* element = fine.element(order.vertices[v]);
        coarse.values.insert(coarse.values.end(), element, element + fine.components);
    }
    return coarse;
}

/// Elements in the order in which corners name them first.
MeshAttribute of_corners(const MeshAttribute& fine, const std::vector<Index>& corners,
                         const PolygonMesh& coarse) {
    MeshAttribute result{fine.name, fine.components, fine.type, {}, {}};
    std::vector<std::int32_t> number(static_cast<std::size_t>(fine.element_count()), -1);
    for (std::int64_t f = 0; f < coarse.polygon_count(); ++f) {
        const auto first = static_cast<std::size_t>(coarse.offsets[static_cast<std::size_t>(f)]);
        const std::size_t size = coarse.polygon(f).size();
        const auto known = [&](Index corner) { return fine.corners[corner] >= 0; };
        const auto begin = corners.begin() + static_cast<std::ptrdiff_t>(first);
        const bool all = std::all_of(begin, begin + static_cast<std::ptrdiff_t>(size), known);
        for (std::size_t c = first; c < first + size; ++c) {
            if (!all) {
                result.corners.push_back(-1);
                continue;
            }
            const std::int32_t own = fine.corners[corners[c]];
            std::int32_t& element = number[static_cast<std::size_t>(own)];
            if (element < 0) {
                element = static_cast<std::int32_t>(result.element_count());
                result.values.insert(result.values.end(), fine.element(own),
                                     fine.element(own) + fine.components);
            }
            result.corners.push_back(element);
        }
    }
    return result;
}

}  // namespace

void take_coarse_extras(const PolygonMesh& fine, const MeshOrder& order,
                        const MeshHierarchy& hierarchy, int depth, PolygonMesh& coarse) {
    const bool splits_faces = hierarchy.spec().scheme != multires::MeshScheme::Sqrt3;
    std::vector<Index> corners;
    if (splits_faces) corners = finest_corners(order, hierarchy, depth);
    for (const MeshAttribute& attribute : fine.attributes)
        if (!attribute.face_varying())
            coarse.attributes.push_back(of_vertices(attribute, order, coarse.vertices.size()));
        else if (splits_faces)
            coarse.attributes.push_back(of_corners(attribute, corners, coarse));
    if (!splits_faces) return;
    const auto sides = static_cast<Index>(hierarchy.topology(hierarchy.steps()).sides);
    for (const FaceLabels& labels : fine.labels) {
        FaceLabels& added =
            coarse.labels.emplace_back(FaceLabels{labels.keyword, labels.names, {}});
        for (std::int64_t f = 0; f < coarse.polygon_count(); ++f) {
            const auto first =
                static_cast<std::size_t>(coarse.offsets[static_cast<std::size_t>(f)]);
            added.of_face.push_back(labels.of_face[corners[first] / sides]);
        }
    }
}

}  // namespace relief::codec
