#pragma once

#include <cstdint>

#include "relief/mesh/split.h"

/// Labels of the faces of a split mesh: each face of such a mesh has one old corner, but for those
/// in the middle of Loop's triangles, which have none, and those that odd sqrt(3) steps leave on
/// the boundary, which have two. A label tells those of all neighbours.
namespace relief::mesh {

/// 0 .. 3: the corner that is old (Catmull-Clark: V of V, E, F, E).
using Label = std::uint8_t;
inline constexpr Label kCentre = 4;  ///< Loop: no corner
inline constexpr Label kPair =
    5;  ///< odd sqrt(3): kPair + j: corners j and j + 1, boundary between
inline constexpr Label kUnlabelled = 255;

inline constexpr int kConflict = -1;
/// The label of the face across side k, which is its side m. kConflict: there can be none.
[[nodiscard]] inline int label_across(Split split, Label label, Index k, Index m) {
    if (split == Split::CatmullClark) return static_cast<int>((m + (k + 5 - label) % 4) % 4);
    if (label == kCentre) return static_cast<int>((m + 2) % 3);
    if (label >= kPair) {
        const Index j = label - kPair;
        if (k == j) return kConflict;
        return static_cast<int>(k == (j + 1) % 3 ? (m + 1) % 3 : m);
    }
    const Index side = (k + 3 - label) % 3;
    if (side == 0) return static_cast<int>((m + 1) % 3);
    if (side == 2) return static_cast<int>(m);
    return split == Split::Loop ? int{kCentre} : static_cast<int>((m + 2) % 3);
}

/// Whether a face may have `label` of which `wanted` is known from across its side m.
[[nodiscard]] inline bool agrees(Label label, int wanted, Index m) {
    if (label < kPair) return label == wanted;
    const Index j = label - kPair;
    if (m == (j + 1) % 3) return wanted == static_cast<int>(m);
    return m == (j + 2) % 3 && wanted == static_cast<int>((m + 1) % 3);
}

/// Whether side k may be on the boundary.
[[nodiscard]] inline bool may_end(Split split, Label label, Index k) {
    switch (split) {
        case Split::Loop:
            return label != kCentre && k != (label + 1U) % 3;
        case Split::CatmullClark:
            return k == label || k == (label + 3U) % 4;
        case Split::Sqrt3Odd:
            return label >= kPair && k + kPair == label;
        case Split::Sqrt3Even:
            return true;
    }
    return false;
}

/// Which roles faces give to a vertex; each has one.
using Role = std::uint8_t;
inline constexpr Role kOld = 1;
inline constexpr Role kEdgePoint = 2;
inline constexpr Role kFacePoint = 4;

[[nodiscard]] inline Role role_of(Split split, Label label, Index corner) {
    if (split == Split::CatmullClark) {
        const Index place = (corner + 4 - label) % 4;
        return place == 0 ? kOld : place == 2 ? kFacePoint : kEdgePoint;
    }
    const Role fresh = split == Split::Loop ? kEdgePoint : kFacePoint;
    if (label >= kPair) {
        const Index j = label - kPair;
        return corner == (j + 2) % 3 ? fresh : kOld;
    }
    return corner == label ? kOld : fresh;
}

}  // namespace relief::mesh
