#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "edit/mesh_drawing.h"
#include "edit/mesh_spread.h"
#include "edit/model.h"

namespace relief::edit {

/// A mesh with subdivision connectivity. The points of all depths are kept: a group changes those
/// of its depth and, step by step, what of the finer ones depends on them; see MeshSpread.
class MeshModel final : public Model {
  public:
    [[nodiscard]] static Result<std::unique_ptr<Model>> open(
        std::shared_ptr<const ByteSource> source);

    [[nodiscard]] const Description& description() const override { return description_; }
    /// Of the finest level; grows while it is edited.
    [[nodiscard]] Bounds bounds() const override { return bounds_; }
    [[nodiscard]] std::unique_ptr<NetGraph> graph(int level) const override;
    [[nodiscard]] Status check(const PointMove& move) const override;
    Status push(std::vector<PointMove> group) override;
    Status drag(std::vector<PointMove> group) override;
    void pop() override;
    [[nodiscard]] Result<Change> changes(const View& view,
                                         const std::vector<TileName>& held) override;
    [[nodiscard]] Result<SurfaceGeometry> surface(const View& view) const override;
    [[nodiscard]] Result<TileGeometry> tile(const View& view, const TileName& name) const override;
    [[nodiscard]] Result<NetGeometry> net(int level,
                                          const std::optional<LatticeBox>& window) const override;
    /// Nothing anywhere: a mesh is no function of a plane.
    [[nodiscard]] Result<std::optional<Probe>> at(const View& view, Vec2 page) const override;
    [[nodiscard]] Result<Bytes> file() const override;
    /// Distances of vertices from where they were, at the level of the view; of the compressed mesh
    /// at the finest level.
    [[nodiscard]] Result<Measurement> measure(const View& view) const override;
    [[nodiscard]] Result<Compression> compress(double max_error, const Progress& progress) override;

  private:
    /// A vertex of some depth, and where it was.
    struct Before {
        mesh::Index vertex = 0;
        Vec3<double> point;
    };
    struct Group {
        std::uint64_t id = 0;  ///< no other has or had it
        std::vector<PointMove> moves;
        std::vector<std::vector<Before>> before;  ///< [depth]
    };
    struct Drag {
        std::uint64_t state = 0;  ///< the group below
        MeshSpread spread;
    };
    /// Vertices that changed since the last report.
    struct Touched {
        std::vector<mesh::Index> vertices;
        std::vector<bool> is_touched;  ///< [vertex]
    };

    MeshModel(std::shared_ptr<const ByteSource> source, codec::MeshFile file,
              codec::MeshParts parts);
    void describe();
    Status add_own_moves();

    [[nodiscard]] int depth_of(int level) const { return levels_.steps() - level; }
    [[nodiscard]] mesh::Index vertex_of(int depth, std::uint64_t point) const;
    [[nodiscard]] std::uint64_t state() const { return groups_.empty() ? 0 : groups_.back().id; }
    /// The points before, which change.
    Result<std::vector<std::vector<Before>>> change(int depth, std::vector<VertexChange> changes,
                                                    MeshSpread& spread);
    Status add(std::vector<PointMove> group, MeshSpread& spread);
    void touch(std::size_t depth, mesh::Index v);
    [[nodiscard]] MeshDrawing drawing(int level, const std::vector<MeshPoints>& points) const;
    [[nodiscard]] Result<SurfaceGeometry> compressed_surface(const View& view) const;
    void add_uv(int level, SurfaceGeometry& out) const;
    /// In the numbers of decode(0).
    [[nodiscard]] MeshPoints original_by_number() const;

    std::shared_ptr<const ByteSource> source_;
    codec::MeshFile file_;
    MeshLevels levels_;
    std::vector<mesh::Index> vertex_of_number_;  ///< of the finest depth
    std::vector<MeshPoints> points_;             ///< [depth]
    std::vector<MeshPoints> original_;           ///< [depth]: with the file's own moves
    std::vector<Group> groups_;
    std::uint64_t last_id_ = 0;
    std::optional<Drag> drag_;
    std::vector<Touched> touched_;  ///< [depth]
    std::optional<codec::MeshFile> compressed_;
    Description description_;
    Bounds bounds_;
};

}  // namespace relief::edit
