#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "codec/ps_places.h"
#include "relief/mesh/triangulation.h"

/// The triangulation of a file of a Powell-Sabin spline: docs/format.md, "Mesh chunk of splines".
namespace relief::codec {

/// What the header says of it.
struct PsBaseHeader {
    std::uint64_t vertices = 0;
    std::uint64_t triangles = 0;
    PlaceGrid grid;
    /// The triangles are those of mesh::delaunay, so peeled; none: they are in the chunk.
    std::optional<double> peel;
};

/// How two triangulations differ that have the same vertices and triangles.
struct PsNumbering {
    std::vector<mesh::Index> vertices;   ///< of each vertex, its number in the other
    std::vector<mesh::Index> triangles;  ///< of each triangle
    std::vector<mesh::Index> turns;  ///< corner k of a triangle is corner k + turn of the other's
};
/// Of two lists of triangles whose vertices are known to correspond; none if some triangle has no
/// other. Complexity: O(n log n).
[[nodiscard]] std::optional<PsNumbering> numbering_of(
    std::span<const std::array<mesh::Index, 3>> triangles,
    std::span<const std::array<mesh::Index, 3>> others, std::vector<mesh::Index> vertices);

struct CodedPsBase {
    PsBaseHeader header;
    Bytes chunk;
    mesh::Triangulation mesh;              ///< what it decodes to
    std::optional<PsNumbering> numbering;  ///< of `mesh` in the source; none: the same
};

/// The same triangulation, to the bit of every coordinate; without keep_order perhaps numbered in
/// another way. Errors: those of mesh::build. Complexity: O(n log n), mostly one or two
/// mesh::delaunay.
[[nodiscard]] Result<CodedPsBase> encode_ps_base(const mesh::Triangulation& mesh, bool keep_order);

/// How many vertices and triangles a triangulation has after triadic refinement; at most 2^62.
struct PsLevelCounts {
    std::uint64_t vertices = 0;
    std::uint64_t edges = 0;
    std::uint64_t triangles = 0;
};
[[nodiscard]] PsLevelCounts level_counts(const mesh::Triangulation& base, int refined);

/// Errors: BadFile. Memory: O(vertices + triangles).
[[nodiscard]] Result<mesh::Triangulation> decode_ps_base(std::span<const std::uint8_t> chunk,
                                                         const PsBaseHeader& header);

}  // namespace relief::codec
