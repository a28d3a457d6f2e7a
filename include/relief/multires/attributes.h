#pragma once

#include <cstdint>
#include <vector>

#include "relief/mesh/split.h"

/// Attributes of corners and labels of faces through Loop and Catmull-Clark splits. Triangles of
/// sqrt(3) lie across two coarse ones, so that they have no corners' values of one face.
namespace relief::multires {

/// Values with seams: corners that name the same element are joined.
struct CornerValues {
    int components = 1;
    std::vector<double> values;           ///< `components` an element
    std::vector<std::int32_t> of_corner;  ///< [half-edge] an element; -1 at all corners of a face
};

/// After a split: old corners keep their elements, points on edges and in faces have the means
/// along each face's own corners. Edges whose ends are joined on both sides stay joined. Requires:
/// split is Loop or CatmullClark, an entry of of_corner for each half-edge. Complexity: O(n).
[[nodiscard]] CornerValues subdivided(const mesh::Topology& coarse, mesh::Split split,
                                      const CornerValues& corners);

/// Faces are called as those that they are parts of. Requires: as above, one label a face.
[[nodiscard]] std::vector<std::int32_t> subdivided_labels(const mesh::Topology& coarse,
                                                          mesh::Split split,
                                                          const std::vector<std::int32_t>& labels);

}  // namespace relief::multires
