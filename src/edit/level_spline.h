#pragma once

#include <span>

#include "relief/mesh/index.h"
#include "relief/spline/fvs_element.h"

namespace relief::edit {

/// The spline of a level, of one component or of three, ready to be asked where its mesh is: what
/// it is at a vertex depends on that vertex alone, and on an edge on its ends. Jets have
/// components() places for each point. Several threads may ask.
class LevelSpline {
  public:
    LevelSpline() = default;
    LevelSpline(const LevelSpline&) = delete;
    LevelSpline& operator=(const LevelSpline&) = delete;
    virtual ~LevelSpline() = default;

    [[nodiscard]] virtual std::size_t components() const = 0;
    /// Values and gradients; second derivatives stay.
    virtual void at_vertex(mesh::Index v, spline::PlaneJet* jets) const = 0;
    /// The same at a part of the way from the first end of an edge to the second.
    virtual void on_edge(mesh::Index e, double part, spline::PlaneJet* jets) const = 0;
    /// Whole jets in a cell, its border included, at points relative to the mesh's origin.
    virtual void in_cell(mesh::Index c, std::span<const Vec2> points,
                         spline::PlaneJet* jets) const = 0;
};

}  // namespace relief::edit
