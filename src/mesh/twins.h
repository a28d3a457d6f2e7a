#pragma once

#include "relief/mesh/topology.h"

namespace relief::mesh {

/// Sets the twins of a mesh whose faces are there. Returns a half-edge of an edge with more than
/// two half-edges, or two in the same direction; kNone: there is none. Complexity: O(n), and
/// O(m log m) for edges whose smaller vertex has m of them.
[[nodiscard]] Index find_twins(Topology& mesh);

/// Sets the numbers of edges of a mesh whose twins are there.
void number_edges(Topology& mesh);

}  // namespace relief::mesh
