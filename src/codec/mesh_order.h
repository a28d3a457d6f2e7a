#pragma once

#include <span>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/stream.h"
#include "relief/multires/mesh_hierarchy.h"

namespace relief::codec {

using multires::MeshHierarchy;

/// How the finest level of a hierarchy and the mesh that it stands for differ.
struct MeshOrder {
    std::vector<mesh::Index> vertices;  ///< of each vertex of the hierarchy, its number in the mesh
    std::vector<mesh::Index> corners;   ///< of each face, where it begins among the mesh's corners

    friend bool operator==(const MeshOrder&, const MeshOrder&) = default;
};

/// Both count alike.
[[nodiscard]] MeshOrder same_order(const mesh::Topology& finest);

/// Other programs number by rules of their own: faces that come from one face by a stride, vertices
/// as faces name them first, or those of each step by themselves. Where such a rule holds, numbers
/// cost almost nothing. Empty if both count alike. Complexity: O(n).
[[nodiscard]] Bytes write_order(const MeshOrder& order, const MeshHierarchy& hierarchy);
/// Errors: BadFile, also for numbers that do not occur once each.
[[nodiscard]] Result<MeshOrder> read_order(std::span<const std::uint8_t> bytes,
                                           const MeshHierarchy& hierarchy);

}  // namespace relief::codec
