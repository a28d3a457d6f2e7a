#pragma once

#include <span>
#include <vector>

#include "codec/mesh_base.h"
#include "codec/mesh_header.h"
#include "codec/mesh_order.h"
#include "relief/core/polygon_mesh.h"
#include "relief/core/stream.h"

/// What a file of a mesh holds beside its shape. docs/format.md, "Meshes".
namespace relief::codec {

/// The numbers of a base in the order in which its connectivity is coded: vertices, and half-edges
/// that faces begin with. Empty if they are the same.
[[nodiscard]] Bytes write_base_order(const CodedBase& coded, const mesh::Topology& base);
/// The base in its own order. Errors: BadFile.
[[nodiscard]] Result<BaseMesh> in_own_order(std::span<const std::uint8_t> bytes, BaseMesh coded);

/// Sharp edges and corners of the base; empty: none.
[[nodiscard]] Bytes write_tags(const multires::MeshTags& tags);
/// Errors: BadFile.
[[nodiscard]] Result<multires::MeshTags> read_tags(std::span<const std::uint8_t> bytes,
                                                   const mesh::Topology& base);

/// Numbers of the mesh's elements, in the order of the hierarchy: what is near is coded together.
/// Vertices of an attribute are expected between those that they lie between.
[[nodiscard]] Bytes write_attributes(const PolygonMesh& mesh,
                                     const std::vector<AttributeHeader>& headers,
                                     const MeshHierarchy& hierarchy, const MeshOrder& order);
/// Of the first `depth` steps; face-varying ones of all steps only. Errors: BadFile.
[[nodiscard]] Result<std::vector<MeshAttribute>> read_attributes(
    std::span<const std::uint8_t> bytes, const std::vector<AttributeHeader>& headers,
    const MeshHierarchy& hierarchy, const MeshOrder& order);

[[nodiscard]] Bytes write_labels(const PolygonMesh& mesh, const MeshOrder& order,
                                 mesh::Index sides);
/// labels: names are there. Errors: BadFile.
[[nodiscard]] Status read_labels(std::span<const std::uint8_t> bytes, const MeshOrder& order,
                                 mesh::Index sides, std::vector<FaceLabels>& labels);

[[nodiscard]] Bytes write_creases(const PolygonMesh& mesh);
/// All of the chunk of creases where they come from the base's tags, in the order of its edges.
inline constexpr std::uint8_t kCreasesOfTags = 0;
/// What is sharp for ever at a depth, in the numbers of the hierarchy. corners: [vertex] 1 for
/// sharp ones; shorter than the vertices: none of the others.
void add_creases(const multires::MeshHierarchy& hierarchy, int depth,
                 std::span<const std::uint8_t> corners, PolygonMesh& mesh);
/// Errors: BadFile.
[[nodiscard]] Status read_creases(std::span<const std::uint8_t> bytes, PolygonMesh& mesh);

/// What lossless files add to the coordinates: how far each is off, in the lattice.
[[nodiscard]] Bytes write_exact(std::span<const Vec3<double>> decoded,
                                std::span<const Vec3<double>> exact, const ValueLattice& lattice);
/// In place. Errors: BadFile.
[[nodiscard]] Status read_exact(std::span<const std::uint8_t> bytes, const ValueLattice& lattice,
                                std::span<Vec3<double>> points);

}  // namespace relief::codec
