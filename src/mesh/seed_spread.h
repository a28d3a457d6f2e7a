#pragma once

#include <array>
#include <vector>

#include "mesh/split_labels.h"

/// All labels that the first face of a component may have, spread over it at once. Source:
/// performance.md section 4.1.
namespace relief::mesh {

/// A way to label a component begins with the way's number as the label of its first face; Loop: 3
/// is kCentre. A byte holds the labels of a face in all ways, two bits each, way 0 lowest.
inline constexpr std::size_t kMostWays = 4;
using PackedLabels = std::uint8_t;

[[nodiscard]] inline std::size_t way_count(Split split) {
    return split == Split::Loop || split == Split::CatmullClark ? 4 : 3;
}

[[nodiscard]] inline Label label_in(Split split, PackedLabels labels, std::size_t way) {
    const auto code = static_cast<Label>(labels >> 2 * way & 3);
    return split == Split::Loop && code == 3 ? kCentre : code;
}

/// Roles of a vertex in all ways, three bits each.
using PackedRoles = std::uint16_t;
[[nodiscard]] inline Role role_in(PackedRoles roles, std::size_t way) {
    return static_cast<Role>(roles >> 3 * way & 7);
}
/// [corner][labels]: what a face with these labels gives.
using RoleTable = std::array<std::array<PackedRoles, 256>, 4>;
[[nodiscard]] const RoleTable& role_table(Split split);

/// Why a way ended, and at which face.
struct Conflict {
    const char* reason = nullptr;  ///< null: it did not
    Index face = 0;
};

inline constexpr const char* kLabelConflict = "faces around it ask different things of one";
inline constexpr const char* kBoundaryPattern = "its boundary does not have the pattern";

struct SeedSpread {
    Components parts;
    std::vector<PackedLabels> labels;                        ///< [face]
    std::vector<std::array<Conflict, kMostWays>> conflicts;  ///< [component][way]
};

/// Requires: faces with as many sides as those of the split. Complexity: O(n).
[[nodiscard]] SeedSpread spread_seeds(const Topology& fine, Split split);

}  // namespace relief::mesh
