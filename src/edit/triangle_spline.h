#pragma once

#include <vector>

#include "edit/level_spline.h"
#include "relief/multires/ps_space.h"

namespace relief::edit {

/// A Powell-Sabin spline of a level, with what moves add to its coefficients.
class TriangleSpline final : public LevelSpline {
  public:
    using Components = std::vector<multires::ps::Coefficients>;

    /// The first `components` of both are used; `added` may be null. All must outlive this.
    TriangleSpline(const multires::ps::Space& space, std::size_t components,
                   const Components& original, const Components* added)
        : space_(space), components_(components), original_(original), added_(added) {}

    [[nodiscard]] std::size_t components() const override { return components_; }
    void at_vertex(mesh::Index v, spline::PlaneJet* jets) const override;
    void on_edge(mesh::Index e, double part, spline::PlaneJet* jets) const override;
    void in_cell(mesh::Index c, std::span<const Vec2> points,
                 spline::PlaneJet* jets) const override;

    /// The coefficients of a vertex.
    [[nodiscard]] multires::ps::Heights heights(std::size_t component, mesh::Index v) const;

  private:
    [[nodiscard]] spline::TangentPlane plane(std::size_t component, mesh::Index v) const;

    const multires::ps::Space& space_;
    std::size_t components_;
    const Components& original_;
    const Components* added_;
};

}  // namespace relief::edit
