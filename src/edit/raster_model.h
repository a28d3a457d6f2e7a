#pragma once

#include <map>
#include <vector>

#include "edit/model.h"
#include "edit/raster_jets.h"

namespace relief::edit {

/// A raster: its surface is the file's plus, level by level, that of the moves.
class RasterModel final : public Model {
  public:
    [[nodiscard]] static Result<std::unique_ptr<RasterModel>> open(
        std::shared_ptr<const ByteSource> source, const OpenOptions& options);

    [[nodiscard]] const Description& description() const override { return description_; }
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

    /// Page place of a place in the finest lattice.
    [[nodiscard]] Vec2 page_place(double row, double col) const;

  private:
    struct Group {
        std::vector<multires::Move> moves;
        MoveFields::Undo undo;
    };
    struct Shown {
        const OriginalSurfaces* surfaces = nullptr;
        bool own = false;    ///< with the file's own moves
        bool added = false;  ///< with the session's
        int level = 0;
    };
    /// Coefficients of a level without the moves of that level.
    struct NetBase {
        int level = -1;
        LatticeBox window;
        multires::LevelCoefficients<double> coefficients;
    };
    using CacheKey = std::tuple<const OriginalSurfaces*, int, int, TileName>;

    RasterModel(std::shared_ptr<const ByteSource> source, codec::RasterFile whole,
                codec::RasterFile bare);
    Status describe(const OpenOptions& options);

    [[nodiscard]] Shown shown(const View& view) const;
    [[nodiscard]] Places places_of(const TileName& name, const LatticeBox& rect) const;
    [[nodiscard]] Result<LatticeBox> rect_of(const TileName& name) const;
    /// A tile of the file's surface, kept while it is used.
    [[nodiscard]] Result<const OriginalSurfaces::Part*> cached(const Shown& shown,
                                                               const TileName& name,
                                                               int derivatives) const;
    [[nodiscard]] Result<OriginalSurfaces::Part> jets(const Shown& shown, const TileName& name,
                                                      const LatticeBox& rect,
                                                      int derivatives) const;
    [[nodiscard]] Status add_moves(const Shown& shown, const Places& places, int derivatives,
                                   std::vector<Jets>& components) const;
    [[nodiscard]] Result<TileGeometry> geometry(const View& view, const TileName& name,
                                                const LatticeBox& rect) const;
    void draw(const Places& places, const OriginalSurfaces::Part& part, const Extras& extras,
              TileGeometry& out) const;
    void draw_errors(const OriginalSurfaces::Part& part, const OriginalSurfaces::Part& original,
                     TileGeometry& out) const;
    [[nodiscard]] Result<const multires::LevelCoefficients<double>*> net_base(
        int level, const LatticeBox& window) const;
    [[nodiscard]] std::array<double, 4> coefficient(int level, std::int64_t row,
                                                    std::int64_t col) const;
    [[nodiscard]] Point net_place(int level, std::int64_t row, std::int64_t col) const;
    [[nodiscard]] multires::Move file_move(const PointMove& move) const;
    void forget_nets_below(const std::vector<multires::Move>& moves) const;

    std::shared_ptr<const ByteSource> source_;
    codec::RasterFile whole_;  ///< with its own moves
    codec::RasterFile bare_;   ///< without them
    OriginalSurfaces surfaces_;
    MoveFields own_;
    MoveFields added_;
    std::vector<Group> groups_;
    std::vector<multires::Move> changed_;  ///< since the last report
    std::unique_ptr<codec::RasterFile> compressed_;
    std::unique_ptr<OriginalSurfaces> compressed_surfaces_;
    Description description_;
    mutable Bounds bounds_;
    mutable std::map<CacheKey, std::pair<std::uint64_t, OriginalSurfaces::Part>> cache_;
    mutable std::uint64_t uses_ = 0;
    mutable NetBase net_;
};

}  // namespace relief::edit
