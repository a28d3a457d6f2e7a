#pragma once

#include <array>
#include <span>
#include <vector>

#include "relief/core/buffer.h"
#include "relief/core/vec2.h"
#include "relief/mesh/index.h"

/// The Delaunay triangulation of sites of a lattice, made by inserting one after the other and
/// flipping edges.
namespace relief::mesh {

/// Half-edges 3t .. 3t + 2 run round triangle t counter-clockwise, from the corners `origin`. The
/// plane is closed by a vertex at infinity, number sites.size(), to which every edge of the hull
/// has a triangle.
struct FlipMesh {
    std::span<const Vec2> sites;
    Buffer<Index> origin;
    Buffer<Index> twin;
    Index triangle_count = 0;

    [[nodiscard]] static Index next(Index h) { return h % 3 == 2 ? h - 2 : h + 1; }
    [[nodiscard]] static Index prev(Index h) { return h % 3 == 0 ? h + 2 : h - 1; }
    [[nodiscard]] Index infinite() const { return static_cast<Index>(sites.size()); }
    [[nodiscard]] bool is_finite(Index t) const {
        return origin[3 * t] != infinite() && origin[3 * t + 1] != infinite() &&
               origin[3 * t + 2] != infinite();
    }
};

/// Requires: sites are different integers of up to 51 bits; `order` names each once, its first
/// three are not collinear. Four sites on a circle get the diagonal that delaunay.h says.
/// Complexity: O(n) steps expected if the order is random or along a curve in rounds of doubling
/// size.
[[nodiscard]] FlipMesh triangulate(std::span<const Vec2> sites, std::span<const Index> order);

}  // namespace relief::mesh
