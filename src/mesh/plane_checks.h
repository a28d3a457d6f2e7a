#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mesh/box_tree.h"
#include "relief/core/result.h"

/// Checks of convex polygons in the plane, of any number of corners.
namespace relief::mesh {

/// BadInput at an element.
[[nodiscard]] Error bad_mesh(std::string message, const char* element, std::size_t number);

/// Whether all points are finite and within 1e150, so that areas do not overflow; `name` is that of
/// the error, `element` what a point is called.
[[nodiscard]] Status check_coordinates(std::span<const Vec2> points, const char* name,
                                       const char* element);

/// An edge of one face only.
struct BoundaryEdge {
    Index from = 0;
    Index to = 0;
    Index face = 0;
    Index near = kNone;  ///< a vertex that may come close to it
};

/// A vertex that lies inside an edge to which it does not belong.
struct HangingVertex {
    Index vertex = 0;
    BoundaryEdge edge;
};

/// The first edge, in their order, that has one of some vertices within 1e-9 of it, relative to its
/// length and not that near to its ends, and the smallest such vertex. Complexity: O(n log n) but
/// for edges that have many vertices in their boxes.
[[nodiscard]] std::optional<HangingVertex> find_hanging_vertex(std::span<const double> x,
                                                               std::span<const double> y,
                                                               std::span<const Index> vertices,
                                                               std::span<const BoundaryEdge> edges);

/// Whether two convex counter-clockwise polygons have more in common than their borders, up to a
/// strip of 1e-9 of the smaller one's longest side.
[[nodiscard]] bool interiors_meet(std::span<const Vec2> a, std::span<const Vec2> b);

/// The smallest pair, in lexicographic order, of faces 0 .. count - 1 whose interiors meet;
/// corners(f) are those of face f. Complexity: O(n log n) and the pairs of overlapping boxes.
template <class Corners>
[[nodiscard]] std::optional<std::array<Index, 2>> find_overlap(Index count, Corners&& corners) {
    std::vector<Box> boxes;
    boxes.reserve(count);
    for (Index f = 0; f < count; ++f) boxes.push_back(box_of(corners(f)));
    const BoxTree tree(boxes);
    for (Index f = 0; f < count; ++f) {
        const auto polygon = corners(f);
        Index found = kNone;
        tree.search([&](const Box& box) { return boxes[f].meets(box); },
                    [&](Index other) {
                        if (other <= f || other >= found || !boxes[f].meets(boxes[other])) return;
                        if (interiors_meet(polygon, corners(other))) found = other;
                    });
        if (found != kNone) return std::array{f, found};
    }
    return std::nullopt;
}

}  // namespace relief::mesh
