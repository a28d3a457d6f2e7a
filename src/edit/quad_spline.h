#pragma once

#include "edit/level_spline.h"
#include "relief/multires/fvs_mesh.h"

namespace relief::edit {

/// A C1 cubic spline of a level, with what moves add to it.
class QuadSpline final : public LevelSpline {
  public:
    using Data = multires::fvs_mesh::NodalData;

    /// `added` may be null. All must outlive this.
    QuadSpline(const mesh::Quadrangulation& mesh, const Data& original, const Data* added)
        : mesh_(mesh), original_(original), added_(added) {}

    [[nodiscard]] std::size_t components() const override { return 1; }
    void at_vertex(mesh::Index v, spline::PlaneJet* jet) const override;
    void on_edge(mesh::Index e, double part, spline::PlaneJet* jet) const override;
    void in_cell(mesh::Index c, std::span<const Vec2> points,
                 spline::PlaneJet* jets) const override;

  private:
    /// A number of the spline.
    [[nodiscard]] double number(std::vector<double> Data::*numbers, mesh::Index at) const {
        const double original = (original_.*numbers)[at];
        return added_ ? original + (added_->*numbers)[at] : original;
    }

    const mesh::Quadrangulation& mesh_;
    const Data& original_;
    const Data* added_;
};

}  // namespace relief::edit
