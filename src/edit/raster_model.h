#pragma once

#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "edit/model.h"
#include "edit/raster_net.h"
#include "edit/raster_tiles.h"

namespace relief::edit {

/// A raster: its surface is the file's plus, level by level, that of the moves.
class RasterModel final : public Model {
  public:
    [[nodiscard]] static Result<std::unique_ptr<Model>> open(
        std::shared_ptr<const ByteSource> source, const OpenOptions& options);

    [[nodiscard]] const Description& description() const override { return description_; }
    /// Grows while tiles are drawn.
    [[nodiscard]] Bounds bounds() const override { return bounds_; }
    [[nodiscard]] std::unique_ptr<NetGraph> graph(int level) const override;
    [[nodiscard]] Status check(const PointMove& move) const override;
    Status push(std::vector<PointMove> group) override;
    void pop() override;
    [[nodiscard]] Result<Change> changes(const View& view,
                                         const std::vector<TileName>& held) override;
    [[nodiscard]] Result<SurfaceGeometry> surface(const View& view) const override;
    [[nodiscard]] Result<TileGeometry> tile(const View& view, const TileName& name) const override;
    [[nodiscard]] Result<NetGeometry> net(int level,
                                          const std::optional<LatticeBox>& window) const override;
    [[nodiscard]] Result<std::optional<Probe>> at(const View& view, Vec2 page) const override;
    [[nodiscard]] Result<Bytes> file() const override;
    [[nodiscard]] Result<Measurement> measure(const View& view) const override;
    [[nodiscard]] Result<Compression> compress(double max_error, const Progress& progress) override;

  private:
    struct Group {
        std::vector<multires::Move> moves;
        MoveFields::Undo undo;
    };
    /// A surface: a file's, with moves or without.
    struct Shown {
        const OriginalSurfaces* surfaces = nullptr;
        const MoveFields* moves = nullptr;  ///< null: none
        int level = 0;
    };
    using CacheKey = std::tuple<const OriginalSurfaces*, int, int, TileName>;
    struct Cached {
        std::uint64_t used = 0;
        OriginalSurfaces::Part part;
    };

    RasterModel(std::shared_ptr<const ByteSource> source, codec::RasterFile bare,
                const std::vector<multires::Move>& own);
    Status describe(const OpenOptions& options);

    [[nodiscard]] Shown shown(const View& view) const;
    [[nodiscard]] Shown original() const { return {&surfaces_, &own_, 0}; }
    [[nodiscard]] Result<const OriginalSurfaces::Part*> cached(const Shown& shown,
                                                               const TileName& name,
                                                               int derivatives) const;
    [[nodiscard]] Result<OriginalSurfaces::Part> jets(const Shown& shown, const TileName& name,
                                                      const LatticeBox& rect,
                                                      int derivatives) const;
    [[nodiscard]] Result<TileGeometry> draw(const View& view, const TileName& name,
                                            const LatticeBox& rect) const;
    void widen(const TileGeometry& tile) const;
    [[nodiscard]] multires::Move file_move(const PointMove& move) const;
    [[nodiscard]] std::vector<multires::Move> all_moves() const;
    [[nodiscard]] Result<const RasterNet*> net_of(int level, const LatticeBox& window) const;
    void mark(const std::vector<multires::Move>& moves);

    std::shared_ptr<const ByteSource> source_;
    std::unique_ptr<codec::RasterFile> bare_;  ///< without moves
    OriginalSurfaces surfaces_;
    std::vector<multires::Move> own_moves_;
    MoveFields own_;  ///< the moves of the file
    MoveFields all_;  ///< those and the groups'
    std::vector<Group> groups_;
    std::vector<multires::Move> changed_;  ///< since the last report
    std::unique_ptr<codec::RasterFile> compressed_;
    std::unique_ptr<OriginalSurfaces> compressed_surfaces_;
    Description description_;
    TileGrid grid_;
    TileFrame frame_;
    mutable Bounds bounds_;
    mutable std::map<CacheKey, Cached> cache_;
    mutable std::uint64_t uses_ = 0;
    mutable std::optional<RasterNet> net_;
};

}  // namespace relief::edit
