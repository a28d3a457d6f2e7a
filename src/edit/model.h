#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "relief/edit/session.h"

/// What a session asks of a surface, for each kind of file once.
namespace relief::edit {

/// A command or question that can not be meant.
[[nodiscard]] inline Error wrong(std::string what) {
    return {ErrorCode::InvalidArgument, std::move(what), ""};
}

inline constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// Bounds of no points at all.
inline constexpr Bounds kNothing{{kInfinite, kInfinite, kInfinite},
                                 {-kInfinite, -kInfinite, -kInfinite}};
inline void include(Bounds& bounds, const Vec3<double>& p) {
    bounds.min = {std::min(bounds.min.x, p.x), std::min(bounds.min.y, p.y),
                  std::min(bounds.min.z, p.z)};
    bounds.max = {std::max(bounds.max.x, p.x), std::max(bounds.max.y, p.y),
                  std::max(bounds.max.z, p.z)};
}

/// All bytes of a file.
[[nodiscard]] inline Result<Bytes> read_all(const ByteSource& source) {
    Bytes bytes(static_cast<std::size_t>(source.size()));
    RELIEF_CHECK(source.read(0, bytes));
    return bytes;
}

/// What a command does to one control point.
struct PointMove {
    int level = 0;
    std::uint64_t point = 0;
    Vec3<double> delta = {};
    Vec2 slope = {};
};

/// The control points of a level as a graph, for falloff.
class NetGraph {
  public:
    NetGraph() = default;
    NetGraph(const NetGraph&) = delete;
    NetGraph& operator=(const NetGraph&) = delete;
    virtual ~NetGraph() = default;

    [[nodiscard]] virtual std::uint64_t count() const = 0;
    virtual void neighbours(std::uint64_t point, std::vector<std::uint64_t>& out) const = 0;
    /// The distance of `to` from the point `source`, when it is reached from its neighbour `from`
    /// at distance `d`: along the edges, or straight where the domain is a plane. Page units.
    [[nodiscard]] virtual double distance(std::uint64_t source, std::uint64_t from, double d,
                                          std::uint64_t to) const = 0;
};

/// An original surface and moves on top of it, a group for each command. What is shown is a
/// function of the original and of the groups in their order.
class Model {
  public:
    Model() = default;
    Model(const Model&) = delete;
    Model& operator=(const Model&) = delete;
    virtual ~Model() = default;

    [[nodiscard]] virtual const Description& description() const = 0;
    [[nodiscard]] virtual Bounds bounds() const = 0;
    /// Requires: a level of the file. Refers to the model, and is valid until that changes.
    [[nodiscard]] virtual std::unique_ptr<NetGraph> graph(int level) const = 0;

    /// Errors: InvalidArgument for a point that does not exist, a displacement that the kind does
    /// not have, or one that its files can not keep.
    [[nodiscard]] virtual Status check(const PointMove& move) const = 0;
    /// Requires: checked moves. Errors: BadFile, when a part that is needed can not be decoded;
    /// then nothing changed.
    virtual Status push(std::vector<PointMove> group) = 0;
    /// The same for a group that is taken away before anything else is done: what the next drag of
    /// the same points needs may be kept. What is shown may differ by less than can be seen.
    virtual Status drag(std::vector<PointMove> group) { return push(std::move(group)); }
    /// Takes the last group away. Requires: there is one.
    virtual void pop() = 0;

    /// What changed since the last call, of what the view shows; `held`: the tiles that it has.
    [[nodiscard]] virtual Result<Change> changes(const View& view,
                                                 const std::vector<TileName>& held) = 0;

    [[nodiscard]] virtual Result<SurfaceGeometry> surface(const View& view) const = 0;
    [[nodiscard]] virtual Result<TileGeometry> tile(const View& view,
                                                    const TileName& name) const = 0;
    [[nodiscard]] virtual Result<NetGeometry> net(
        int level, const std::optional<LatticeBox>& window) const = 0;
    [[nodiscard]] virtual Result<std::optional<Probe>> at(const View& view, Vec2 page) const = 0;

    /// The file with the groups as moves.
    [[nodiscard]] virtual Result<Bytes> file() const = 0;
    [[nodiscard]] virtual Result<Measurement> measure(const View& view) const = 0;
    [[nodiscard]] virtual Result<Compression> compress(double max_error,
                                                       const Progress& progress) = 0;
};

/// Errors: those of the readers of files. `file` was recognised as one of the kind.
[[nodiscard]] Result<std::unique_ptr<Model>> open_raster(std::shared_ptr<const ByteSource> file,
                                                         const OpenOptions& options);
[[nodiscard]] Result<std::unique_ptr<Model>> open_mesh(std::shared_ptr<const ByteSource> file);
[[nodiscard]] Result<std::unique_ptr<Model>> open_quads(std::shared_ptr<const ByteSource> file);
[[nodiscard]] Result<std::unique_ptr<Model>> open_triangles(std::shared_ptr<const ByteSource> file);

/// The moves of a command, those that follow by its falloff included, ordered by point. Errors:
/// InvalidArgument for a point that the level does not have or that is named twice. Complexity:
/// O(points reached, log of it each).
[[nodiscard]] Result<std::vector<PointMove>> spread(const Move& move, const NetGraph& graph);

}  // namespace relief::edit
