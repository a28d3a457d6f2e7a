#pragma once

#include <vector>

#include "edit/vertex_faces.h"
#include "relief/codec/mesh_codec.h"

namespace relief::edit {

using MeshPoints = std::vector<Vec3<double>>;

/// What of an opened mesh does not change.
struct MeshLevels {
    codec::MeshParts parts;
    std::vector<VertexFaces> around;  ///< [depth]
    double tolerance = 0;             ///< changes that are smaller are none

    [[nodiscard]] const multires::MeshHierarchy& hierarchy() const { return *parts.hierarchy; }
    [[nodiscard]] int steps() const { return hierarchy().steps(); }
    [[nodiscard]] const mesh::Topology& topology(int depth) const {
        return hierarchy().topology(depth);
    }
};

struct VertexChange {
    mesh::Index vertex = 0;
    Vec3<double> delta;
};

}  // namespace relief::edit
