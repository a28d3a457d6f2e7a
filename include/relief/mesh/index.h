#pragma once

#include <cstdint>

namespace relief::mesh {

/// Vertices, edges, faces and half-edges count from 0; there are fewer than 2^31 of each.
using Index = std::uint32_t;

/// No element.
inline constexpr Index kNone = ~Index{0};

}  // namespace relief::mesh
