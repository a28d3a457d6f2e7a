#include "edit/plane_samples.h"

#include <cmath>
#include <numeric>

#include "edit/curvature.h"
#include "relief/core/parallel.h"

namespace relief::edit {

using mesh::Index;
using spline::PlaneJet;

namespace {

constexpr std::int64_t kGrain = 64;

std::vector<Index> numbers_below(std::size_t count) {
    std::vector<Index> all(count);
    std::iota(all.begin(), all.end(), Index{0});
    return all;
}

template <class Function>
void for_each_of(const std::vector<Index>& elements, Function&& fn) {
    parallel_for(0, static_cast<std::int64_t>(elements.size()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (auto k = static_cast<std::size_t>(first);
                          k < static_cast<std::size_t>(last); ++k)
                         fn(k, elements[k]);
                 });
}

/// Samples a part element by element.
class Sampler {
  public:
    Sampler(const LevelSpline& spline, const CellGrid& grid, Derivatives derivatives,
            PlaneSamples& out)
        : spline_(spline), grid_(grid), derivatives_(derivatives), out_(out) {}

    void vertex(std::size_t at, Index v) const {
        out_.places[at] = grid_.mesh().vertices[v];
        take_bend(grid_.mesh().vertex_cells.of(v)[0], at, 1);
        spline_.at_vertex(v, out_.at(at));
    }

    void edge(std::size_t at, Index e) const {
        for (std::size_t k = 0; k < grid_.edge_points(); ++k)
            out_.places[at + k] = grid_.edge_place(e, k);
        take_bend(grid_.mesh().edge_cell[e], at, grid_.edge_points());
        for (std::size_t k = 0; k < grid_.edge_points(); ++k)
            spline_.on_edge(e, grid_.edge_part(k), out_.at(at + k));
    }

    void cell(std::size_t at, Index c) const {
        for (std::size_t k = 0; k < grid_.cell_points(); ++k)
            out_.places[at + k] = grid_.cell_place(c, k);
        spline_.in_cell(c, std::span(out_.places).subspan(at, grid_.cell_points()), out_.at(at));
    }

  private:
    /// On the border of cells second derivatives jump: they are those of one of them.
    void take_bend(Index c, std::size_t at, std::size_t count) const {
        if (derivatives_ == Derivatives::First) return;
        spline_.in_cell(c, std::span(out_.places).subspan(at, count), out_.at(at));
    }

    const LevelSpline& spline_;
    const CellGrid& grid_;
    Derivatives derivatives_;
    PlaneSamples& out_;
};

}  // namespace

GridPart GridPart::whole(const CellMesh& mesh) {
    return {numbers_below(mesh.vertices.size()), numbers_below(mesh.edges.size()),
            numbers_below(mesh.cells.size())};
}

std::size_t GridPart::point_count(const CellGrid& grid) const {
    return vertices.size() + edges.size() * grid.edge_points() + cells.size() * grid.cell_points();
}

std::vector<std::uint32_t> GridPart::points(const CellGrid& grid) const {
    std::vector<std::uint32_t> numbers(vertices.begin(), vertices.end());
    numbers.reserve(point_count(grid));
    for (const Index e : edges)
        for (std::size_t k = 0; k < grid.edge_points(); ++k)
            numbers.push_back(grid.edge_point(e, k));
    for (const Index c : cells)
        for (std::size_t k = 0; k < grid.cell_points(); ++k)
            numbers.push_back(grid.cell_point(c, k));
    return numbers;
}

PlaneSamples sample(const LevelSpline& spline, const CellGrid& grid, const GridPart& part,
                    Derivatives derivatives) {
    PlaneSamples out(spline.components(), part.point_count(grid));
    const Sampler sampler(spline, grid, derivatives, out);
    for_each_of(part.vertices, [&](std::size_t k, Index v) { sampler.vertex(k, v); });
    std::size_t start = part.vertices.size();
    if (grid.edge_points() > 0)
        for_each_of(part.edges, [&](std::size_t k, Index e) {
            sampler.edge(start + grid.edge_points() * k, e);
        });
    start += grid.edge_points() * part.edges.size();
    if (grid.cell_points() > 0)
        for_each_of(part.cells, [&](std::size_t k, Index c) {
            sampler.cell(start + grid.cell_points() * k, c);
        });
    return out;
}

namespace {

SurfaceDerivatives derivatives_of(const PlaneJet* jets, bool parametric) {
    if (!parametric)
        return {{1, 0, jets->gradient.x},
                {0, 1, jets->gradient.y},
                {0, 0, jets->xx},
                {0, 0, jets->xy},
                {0, 0, jets->yy}};
    const auto three = [&](auto number) {
        return Vec3<double>{number(jets[0]), number(jets[1]), number(jets[2])};
    };
    return {three([](const PlaneJet& j) { return j.gradient.x; }),
            three([](const PlaneJet& j) { return j.gradient.y; }),
            three([](const PlaneJet& j) { return j.xx; }),
            three([](const PlaneJet& j) { return j.xy; }),
            three([](const PlaneJet& j) { return j.yy; })};
}

}  // namespace

Vec3<double> PlaneFrame::place(Vec2 plan, const PlaneJet* jets) const {
    if (parametric) return Vec3<double>{jets[0].value, jets[1].value, jets[2].value} - origin;
    return {plan.x, plan.y, jets->value - origin.z};
}

Vec3<double> PlaneFrame::normal(const PlaneJet* jets) const {
    const SurfaceDerivatives d = derivatives_of(jets, parametric);
    return unit(cross(d.u, d.v));
}

double PlaneFrame::curvature(const PlaneJet* jets) const {
    return mean_curvature(derivatives_of(jets, parametric), normal(jets));
}

double PlaneFrame::error(const PlaneJet* jets, const PlaneJet* original) const {
    if (!parametric) return jets->value - original->value;
    const Vec3<double> off = place({}, jets) - place({}, original);
    return std::copysign(length(off), dot(off, normal(original)));
}

}  // namespace relief::edit
