#pragma once

#include "relief/multires/ps_split.h"

namespace relief::multires::ps {

/// Sets the weights of all edges of two triangles from the centres, and checks those of the others,
/// which the caller has set. Errors: `edge_not_crossed`, `degenerate_split`.
[[nodiscard]] Status cross_edges(const mesh::Triangulation& mesh, Split& split);

}  // namespace relief::multires::ps
