#pragma once

#include <vector>

#include "edit/cell_grid.h"
#include "edit/level_spline.h"
#include "relief/edit/geometry.h"

/// Splines over the plane at the points of a grid, and how they are drawn.
namespace relief::edit {

/// Vertices, edges and cells whose points are drawn.
struct GridPart {
    std::vector<mesh::Index> vertices;
    std::vector<mesh::Index> edges;
    std::vector<mesh::Index> cells;

    [[nodiscard]] static GridPart whole(const CellMesh& mesh);
    [[nodiscard]] std::size_t point_count(const CellGrid& grid) const;
    /// The numbers of its points: those of the vertices, of the edges, of the cells.
    [[nodiscard]] std::vector<std::uint32_t> points(const CellGrid& grid) const;
};

/// Jets at points, component by component.
struct PlaneSamples {
    std::size_t components = 1;
    std::vector<Vec2> places;  ///< relative to the mesh's origin
    std::vector<spline::PlaneJet> jets;

    PlaneSamples(std::size_t of, std::size_t points)
        : components(of), places(points), jets(of * points) {}
    [[nodiscard]] std::size_t count() const { return places.size(); }
    [[nodiscard]] const spline::PlaneJet* at(std::size_t k) const {
        return jets.data() + components * k;
    }
    [[nodiscard]] spline::PlaneJet* at(std::size_t k) { return jets.data() + components * k; }
};

enum class Derivatives { First, Second };

/// The points of a part in the order of GridPart::points. Complexity: O(points), in parallel.
[[nodiscard]] PlaneSamples sample(const LevelSpline& spline, const CellGrid& grid,
                                  const GridPart& part, Derivatives derivatives);

/// Where jets are in space: graphs of functions, and parametric surfaces, whose jets are those of
/// x, y and z. Page coordinates are relative to `origin`, whose x and y are those of the plane's
/// vertices if the surface is a graph.
struct PlaneFrame {
    Vec3<double> origin;
    bool parametric = false;

    [[nodiscard]] Vec3<double> place(Vec2 plan, const spline::PlaneJet* jets) const;
    [[nodiscard]] Vec3<double> normal(const spline::PlaneJet* jets) const;
    /// Mean curvature, positive where the surface is a valley seen from its normal's side.
    /// Requires: second derivatives.
    [[nodiscard]] double curvature(const spline::PlaneJet* jets) const;
    /// From an original at the same place of the plane: along z, or the whole distance with the
    /// sign of the original's normal.
    [[nodiscard]] double error(const spline::PlaneJet* jets,
                               const spline::PlaneJet* original) const;
};

}  // namespace relief::edit
