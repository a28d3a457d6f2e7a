#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "edit/model.h"
#include "edit/plane_moves.h"
#include "edit/plane_samples.h"

namespace relief::edit {

/// A cell, and a point of it relative to the mesh's origin.
struct CellPlace {
    mesh::Index cell = 0;
    Vec2 point;
};

/// The mesh of a level, how it is drawn, and what commands call its vertices.
class PlaneLevel {
  public:
    /// `number` of each vertex; empty: its own.
    PlaneLevel(CellMesh mesh, std::vector<mesh::Index> number);
    PlaneLevel(const PlaneLevel&) = delete;
    PlaneLevel& operator=(const PlaneLevel&) = delete;

    [[nodiscard]] const CellMesh& mesh() const { return mesh_; }
    [[nodiscard]] const CellGrid& grid() const { return grid_; }
    [[nodiscard]] std::size_t vertex_count() const { return mesh_.vertices.size(); }
    [[nodiscard]] mesh::Index number_of(mesh::Index vertex) const {
        return number_.empty() ? vertex : number_[vertex];
    }
    [[nodiscard]] mesh::Index vertex_of(std::uint64_t number) const {
        return number_.empty() ? static_cast<mesh::Index>(number)
                               : vertex_[static_cast<std::size_t>(number)];
    }

  private:
    CellMesh mesh_;
    CellGrid grid_;
    std::vector<mesh::Index> number_;
    std::vector<mesh::Index> vertex_;
};

/// A spline on quads or triangles of the plane: a function, or of three components a surface in
/// space. Its control points are the vertices of its levels.
class PlaneModel : public Model {
  public:
    [[nodiscard]] const Description& description() const final { return description_; }
    /// Grows while the surface is drawn.
    [[nodiscard]] Bounds bounds() const final { return bounds_; }
    [[nodiscard]] std::unique_ptr<NetGraph> graph(int level) const final;
    Status push(std::vector<PointMove> group) final;
    void pop() final;
    [[nodiscard]] Result<Change> changes(const View& view, const std::vector<TileName>& held) final;
    [[nodiscard]] Result<SurfaceGeometry> surface(const View& view) const final;
    [[nodiscard]] Result<TileGeometry> tile(const View& view, const TileName& name) const final;
    [[nodiscard]] Result<NetGeometry> net(int level,
                                          const std::optional<LatticeBox>& window) const final;
    [[nodiscard]] Result<std::optional<Probe>> at(const View& view, Vec2 page) const final;
    [[nodiscard]] Result<Measurement> measure(const View& view) const final;

  protected:
    using Levels = std::vector<std::unique_ptr<const PlaneLevel>>;
    enum class Outside { None, Nearest };

    /// Makes the model ready: levels from the finest, and a description that lacks the origin of
    /// page coordinates. Requires: `spline` can be asked for the original.
    void set_up(Levels levels, std::unique_ptr<PlaneMoves> moves, Description description);

    /// Refers to the model, and is valid until that changes. Compressed: or else Edited.
    [[nodiscard]] virtual std::unique_ptr<LevelSpline> spline(View::Show show, int level) const = 0;
    /// The cell of a point relative to the mesh's origin.
    [[nodiscard]] virtual std::optional<CellPlace> locate(int level, Vec2 point,
                                                          Outside outside) const = 0;
    /// The corners of a vertex's control triangle in data coordinates, for kinds that have them.
    [[nodiscard]] virtual std::optional<std::array<Vec3<double>, 3>> corners(
        int level, mesh::Index vertex) const = 0;

    [[nodiscard]] const PlaneLevel& level(int level) const {
        return *levels_[static_cast<std::size_t>(level)];
    }
    [[nodiscard]] std::vector<PointMove> all_moves() const;
    /// What all moves of a control point would add up to with one more: not a number of at most
    /// 1e100, InvalidArgument.
    [[nodiscard]] Status check_sum(const PointMove& move) const;

  private:
    struct Group {
        std::vector<PointMove> moves;
        PlaneMoves::Undo undo;
    };
    /// The whole of what is drawn of a part.
    struct Drawn {
        std::vector<Point> position;
        std::vector<PackedNormal> normal;
        std::vector<float> error;
        std::vector<float> curvature;
    };

    void settle() const { moves_->settle(); }
    [[nodiscard]] PlaneSamples sampled(const View& view, const GridPart& part) const;
    [[nodiscard]] PlaneSamples original_at(int level, const GridPart& part,
                                           const std::vector<Vec2>& places) const;
    [[nodiscard]] Drawn draw(const View& view, const GridPart& part) const;
    [[nodiscard]] GridPart part_at(const View& view, const std::vector<mesh::Index>& changed) const;
    void add_to_net(const LevelSpline& spline, int level, mesh::Index vertex,
                    NetGeometry& net) const;

    Levels levels_;
    std::unique_ptr<PlaneMoves> moves_;
    std::vector<Group> groups_;
    Description description_;
    PlaneFrame frame_;
    mutable Bounds bounds_;
};

}  // namespace relief::edit
