#pragma once

#include <span>
#include <vector>

#include "codec/value_lattice.h"
#include "relief/core/result.h"
#include "relief/core/stream.h"
#include "relief/mesh/triangulation.h"

/// Values at the vertices of a triangulation, as integers of lattices: docs/format.md, "Level chunk
/// of values at scattered vertices".
namespace relief::codec {

/// [component][vertex]
using VertexValues = std::vector<std::vector<double>>;

/// Values become the nearest ones of the lattices. Each is predicted from those around it that are
/// known: by their mean and by the plane near them, in the ratio in which both were right before.
/// Requires: a lattice for each component. Complexity: O(n log n).
[[nodiscard]] Bytes encode_ps_values(const mesh::Triangulation& mesh,
                                     std::span<const ValueLattice> lattices,
                                     const VertexValues& values);
/// Errors: BadFile.
[[nodiscard]] Result<VertexValues> decode_ps_values(const mesh::Triangulation& mesh,
                                                    std::span<const ValueLattice> lattices,
                                                    std::span<const std::uint8_t> bytes);

}  // namespace relief::codec
