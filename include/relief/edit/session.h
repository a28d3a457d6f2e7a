#pragma once

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "relief/core/stream.h"
#include "relief/edit/command.h"
#include "relief/edit/geometry.h"

/// Editing a surface of any kind at any level: what the editor, its tests and scripts do. A session
/// knows no files and no screens.
namespace relief::edit {

enum class Kind : std::uint8_t { Raster, Mesh, Quads, Triangles };
/// "raster", "mesh", "quads", "triangles".
[[nodiscard]] const char* kind_name(Kind kind);

struct LevelInfo {
    std::uint64_t control_points = 0;
    std::uint64_t faces = 0;  ///< 0 for rasters
    std::uint64_t bytes = 0;  ///< how many first bytes of the file the level needs
    std::int64_t rows = 0;    ///< of the control net; rasters only
    std::int64_t cols = 0;
};

struct TileInfo {
    std::int64_t rows = 0;  ///< samples
    std::int64_t cols = 0;
    int tile = 128;                       ///< cells of a tile's side
    int coarsest = 0;                     ///< the level of detail at which one tile is everything
    std::array<double, 2> spacing{1, 1};  ///< of samples, page units
};

/// What does not change while a file is edited.
struct Description {
    Kind kind = Kind::Raster;
    std::string scheme;
    int order = 0;                  ///< 0: the scheme has no orders
    std::vector<LevelInfo> levels;  ///< from the finest
    int components = 1;
    bool parametric = false;
    Vec3<double> origin = {};  ///< of page coordinates, in data coordinates
    std::string unit;          ///< of heights and page coordinates; empty: unknown
    std::string crs;
    std::optional<double> bound;  ///< verified largest error of the file before it was edited
    std::uint64_t bytes = 0;
    std::optional<TileInfo> tiles;  ///< rasters
};

struct Bounds {
    Vec3<double> min = {};
    Vec3<double> max = {};
};

struct HistoryEntry {
    std::string text;
    Move move;
};
struct History {
    std::size_t done = 0;  ///< the first so many entries are in effect
    std::vector<HistoryEntry> entries;
};

/// What a page shows, so that a session knows what a change must bring up to date.
struct View {
    enum class Show : std::uint8_t { Edited, Original, Compressed };
    int level = 0;
    Show show = Show::Edited;
    Extras extras = {};

    friend bool operator==(const View&, const View&) = default;
};

/// What a change did to what a view shows.
struct Change {
    std::uint64_t touched = 0;        ///< vertices or samples of the finest level that may differ
    SurfacePatch surface;             ///< kinds but rasters
    std::vector<TileGeometry> tiles;  ///< rasters: of the tiles that the view holds
};

struct Measurement {
    double max_error = 0;
    double rms_error = 0;
    Vec3<double> place = {};  ///< page coordinates of the largest
};

struct Compression {
    std::uint64_t bytes = 0;
    std::int64_t kept = 0;
    std::int64_t coefficients = 0;
    double max_error = 0;
    double rms_error = 0;
    std::shared_ptr<const ByteSource> file = {};  ///< what View::Show::Compressed shows
};

struct Probe {
    double value = 0;
    Vec2 gradient = {};  ///< per page unit
    double slope = 0;    ///< degrees
    Vec2 place = {};     ///< the file's own coordinates
};

/// What a session can not read from a file.
struct OpenOptions {
    /// Sizes of a raster's samples in the unit of its heights, along columns and rows; none: those
    /// of its transform, as if both had the same unit.
    std::optional<std::array<double, 2>> spacing = {};
};

/// An opened file with what was done to it. Not for several threads at once.
///
/// Moves form a list, as in files; what is shown is a function of the file and of that list alone,
/// so that undo gives back every bit. A *drag* is a move that is shown but not in the list.
class Session {
  public:
    /// A .relief file of any kind. Its own moves are part of the original. Errors: those of the
    /// file's reader.
    [[nodiscard]] static Result<Session> open(std::shared_ptr<const ByteSource> file,
                                              const OpenOptions& options = {});
    Session(Session&&) noexcept;
    Session& operator=(Session&&) noexcept;
    ~Session();

    [[nodiscard]] const Description& description() const;
    [[nodiscard]] Bounds bounds() const;
    [[nodiscard]] const History& history() const;
    [[nodiscard]] std::uint64_t revision() const;  ///< grows with each change

    /// What changes report from now on, and which tiles the page has.
    Status set_view(const View& view);
    [[nodiscard]] const View& view() const;
    void hold(const TileName& tile);
    void forget(const TileName& tile);

    /// Everything that the view shows: kinds but rasters. Complexity: O(vertices).
    [[nodiscard]] Result<SurfaceGeometry> surface() const;
    /// A tile of what the view shows; rasters. Complexity: O(samples of the tile) once the file's
    /// part is decoded.
    [[nodiscard]] Result<TileGeometry> tile(const TileName& name) const;
    /// The control net of a level. window: rows and columns of it; rasters of more than 65536
    /// points need one. Errors: InvalidArgument.
    [[nodiscard]] Result<NetGeometry> net(int level, const std::optional<LatticeBox>& window) const;
    /// Nothing outside the domain.
    [[nodiscard]] Result<std::optional<Probe>> at(Vec2 page) const;

    /// Each ends a drag. Complexity: what is touched.
    Result<Change> apply(const Move& move);
    Result<Change> undo(std::size_t count = 1);
    Result<Change> redo(std::size_t count = 1);
    Result<Change> go_to(std::size_t done);
    /// Shows a move in place of the last drag, or (release) none.
    Result<Change> drag(const Move& move);
    Result<Change> release();
    /// One of the protocol's commands, "move" to "release".
    Result<Change> run(const nlohmann::json& command);

    /// The commands in effect: a list of JSON objects, whose replay gives the same file.
    [[nodiscard]] nlohmann::json script() const;
    /// Runs a list of commands, or {"commands": list}. Errors name the command's number; what was
    /// done before it stays.
    Status replay(const nlohmann::json& script);

    /// The edited file: the original with the moves as a layer.
    [[nodiscard]] Result<Bytes> file() const;

    /// Of what is shown, against the original.
    [[nodiscard]] Result<Measurement> measure() const;
    /// Encodes the edited surface with this bound; View::Show::Compressed shows the result.
    [[nodiscard]] Result<Compression> compress(double max_error, const Progress& progress);

  private:
    struct State;
    explicit Session(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace relief::edit
