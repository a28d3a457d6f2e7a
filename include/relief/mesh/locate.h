#pragma once

#include <memory>
#include <optional>

#include "relief/mesh/quadrangulation.h"

namespace relief::mesh {

/// A quad and a point in it, relative to the mesh's origin.
struct Place {
    Index quad = 0;
    Vec2 point;
};

/// Finds the quad of a point. Immutable; several threads may ask. Source: fvs-hierarchical.md
/// section 10.
class Locator {
  public:
    /// The mesh must outlive the locator and keep its address. Complexity: O(n log n).
    explicit Locator(const Quadrangulation& mesh);
    Locator(Locator&&) noexcept;
    Locator& operator=(Locator&&) noexcept;
    ~Locator();

    /// The quad that contains the point, given in the coordinates of the mesh's source; the one of
    /// the smallest number if it lies on an edge. A point outside, but within 1e-12 of its nearest
    /// boundary edge's length, counts as on the edge. Nothing outside the domain, in a hole, or for
    /// a point that is not finite. Complexity: O(log n) but for strongly skewed quads.
    [[nodiscard]] std::optional<Place> locate(Vec2 point) const;

    /// The same for points of the domain; others are moved to the nearest point of the boundary.
    /// Requires: the point is finite, the mesh has quads.
    [[nodiscard]] Place nearest(Vec2 point) const;

  private:
    struct Data;
    std::unique_ptr<const Data> data_;
};

/// Which quad of the refined mesh, 4 parent + 0 .. 3, contains a point of a quad of its parent; on
/// an inner edge that of the smaller number. The point is relative to the origin. Complexity: O(1).
[[nodiscard]] Index child_of(const Quadrangulation& parent, const Quadrangulation& child,
                             const Place& place);

}  // namespace relief::mesh
