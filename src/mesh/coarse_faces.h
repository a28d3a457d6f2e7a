#pragma once

#include <vector>

#include "mesh/split_labels.h"

namespace relief::mesh {

/// Coarse faces whose corners are fine vertices, and the fine half-edges at them.
struct CoarseFaces {
    FaceList faces;
    std::vector<Index> fine;

    void add(Index corner, Index half_edge) {
        faces.corners.push_back(corner);
        fine.push_back(half_edge);
    }
    void end_face() { faces.offsets.push_back(static_cast<std::int64_t>(faces.corners.size())); }
};

/// Those of all fine faces with a label.
[[nodiscard]] CoarseFaces coarse_faces(const Topology& fine, Split split, const Label* labels);

/// With corners counted among all of them, each face from its smallest one, and sorted: by it, and
/// by the second. old: what they were, ascending.
[[nodiscard]] CoarseFaces sorted(const CoarseFaces& coarse, Index vertex_count,
                                 std::vector<Index>& old);

}  // namespace relief::mesh
