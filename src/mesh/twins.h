#pragma once

#include <optional>
#include <span>
#include <vector>

#include "relief/mesh/topology.h"

namespace relief::mesh {

/// Sets the twins of a mesh whose faces are there. Returns half-edges of edges with more than two
/// half-edges, or two in the same direction, which get no twins: one of each. Complexity: O(n), and
/// O(m log m) for edges whose smaller vertex has m of them.
[[nodiscard]] std::vector<Index> find_twins(Topology& mesh);

/// The same where all edges are good, and the faces at each vertex form one fan: then how many
/// vertices have faces. Else twins are left in pieces. Neighbours are looked for among the corners
/// at a vertex, for some thousand vertices after another, so that all but one look at each
/// half-edge stays in the cache, whatever the order of faces. Complexity: as find_twins.
[[nodiscard]] std::optional<Index> link_corners(Topology& mesh);

/// Sets the faces of a mesh. Requires: what build checks of each face.
void set_faces(std::span<const std::int64_t> offsets, std::span<const Index> corners,
               Topology& mesh);

}  // namespace relief::mesh
