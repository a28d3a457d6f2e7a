#pragma once

#include "codec/lattice_level.h"

namespace relief::codec {

/// D and E samples, and the margins, as the fast codec decodes them when every q is 0: the level as
/// far as the coarser one tells it. Their quotients become 0; mask and step do not matter.
/// Complexity: O(samples).
void fill_level(LatticeLevel& level);

}  // namespace relief::codec
