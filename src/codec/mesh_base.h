#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/stream.h"
#include "relief/mesh/topology.h"

/// The coarsest mesh of a file: connectivity and places. docs/format.md, "Connectivity".
namespace relief::codec {

/// Integer coordinates of a vertex.
using GridPoint = std::array<std::int64_t, 3>;

/// A mesh in the order in which it is coded.
struct BaseMesh {
    mesh::FaceList faces;
    std::vector<GridPoint> points;
};

struct CodedBase {
    Bytes bytes;
    std::vector<mesh::Index> vertices;  ///< of the coded vertices, their numbers in the mesh
    std::vector<mesh::Index> corners;   ///< of the coded faces, the half-edges that they begin with
};

/// Faces in the order of a walk along the border of what is known: some 2 to 4 bits a vertex beside
/// the coordinates, which are predicted by parallelograms. Requires: coordinates of at most 2^50.
/// Complexity: O(n).
[[nodiscard]] CodedBase encode_base(const mesh::Topology& mesh, std::span<const GridPoint> points);

/// sides: as in Topology. Errors: BadFile. The faces may still be no manifold. Memory: O(vertices +
/// faces).
[[nodiscard]] Result<BaseMesh> decode_base(std::span<const std::uint8_t> bytes, int sides,
                                           std::uint64_t vertices, std::uint64_t faces);

}  // namespace relief::codec
