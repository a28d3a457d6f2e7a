#pragma once

#include <memory>
#include <vector>

#include "edit/plane_model.h"

namespace relief::edit {

/// The vertices of a level and the edges between them. Distances are straight ones in the plane.
class PlaneGraph : public NetGraph {
  public:
    explicit PlaneGraph(const PlaneLevel& level) : level_(level) {}

    [[nodiscard]] std::uint64_t count() const final { return level_.vertex_count(); }
    void neighbours(std::uint64_t point, std::vector<std::uint64_t>& out) const final {
        for (const mesh::Index v : level_.mesh().neighbours(level_.vertex_of(point)))
            out.push_back(level_.number_of(v));
    }
    [[nodiscard]] double distance(std::uint64_t source, std::uint64_t /*from*/, double /*d*/,
                                  std::uint64_t to) const override {
        return length(place(to) - place(source));
    }

  protected:
    [[nodiscard]] mesh::Index vertex(std::uint64_t point) const { return level_.vertex_of(point); }

  private:
    [[nodiscard]] Vec2 place(std::uint64_t point) const {
        return level_.mesh().vertices[vertex(point)];
    }

    const PlaneLevel& level_;
};

/// The same where the vertices are points of a surface in space: distances are lengths of edges
/// between points of it.
class SurfaceGraph final : public PlaneGraph {
  public:
    SurfaceGraph(const PlaneLevel& level, std::unique_ptr<LevelSpline> surface)
        : PlaneGraph(level), surface_(std::move(surface)) {}

    [[nodiscard]] double distance(std::uint64_t /*source*/, std::uint64_t from, double d,
                                  std::uint64_t to) const override {
        return d + length(place(to) - place(from));
    }

  private:
    [[nodiscard]] Vec3<double> place(std::uint64_t point) const {
        std::array<spline::PlaneJet, 3> jets{};
        surface_->at_vertex(vertex(point), jets.data());
        return {jets[0].value, jets[1].value, jets[2].value};
    }

    std::unique_ptr<LevelSpline> surface_;
};

}  // namespace relief::edit
