#include "edit/mesh_model.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace relief::edit {

namespace {

using mesh::Index;

/// Of the size of the box around the mesh: far below what coordinates of 32 bits show.
constexpr double kTolerance = 0x1p-27;

MeshPoints points_of(const PolygonMesh& mesh) {
    MeshPoints points;
    points.reserve(mesh.vertices.size());
    for (const auto& [x, y, z] : mesh.vertices) points.push_back({x, y, z});
    return points;
}

Result<mesh::Topology> topology_of(const PolygonMesh& mesh) {
    const std::vector<Index> corners(mesh.corners.begin(), mesh.corners.end());
    return mesh::build(mesh.offsets, corners, static_cast<Index>(mesh.vertices.size()));
}

/// The vertices and edges of a level; numbers: what vertices are called, and back.
class MeshGraph final : public NetGraph {
  public:
    MeshGraph(const MeshDrawing& drawing, std::span<const Index> vertex_of_number)
        : drawing_(drawing), vertex_of_number_(vertex_of_number) {}

    [[nodiscard]] std::uint64_t count() const override { return drawing_.points.size(); }
    void neighbours(std::uint64_t point, std::vector<std::uint64_t>& out) const override {
        std::vector<Index> neighbours;
        drawing_.around.neighbours(drawing_.mesh, vertex(point), neighbours);
        for (const Index v : neighbours) out.push_back(drawing_.number(v));
    }
    [[nodiscard]] double distance(std::uint64_t, std::uint64_t from, double d,
                                  std::uint64_t to) const override {
        return d + length(drawing_.points[vertex(to)] - drawing_.points[vertex(from)]);
    }

  private:
    [[nodiscard]] Index vertex(std::uint64_t point) const {
        return drawing_.numbers.empty() ? static_cast<Index>(point) : vertex_of_number_[point];
    }

    MeshDrawing drawing_;
    std::span<const Index> vertex_of_number_;
};

}  // namespace

MeshModel::MeshModel(std::shared_ptr<const ByteSource> source, codec::MeshFile file,
                     codec::MeshParts parts)
    : source_(std::move(source)), file_(std::move(file)) {
    levels_.parts = std::move(parts);
    points_ = std::move(levels_.parts.points);
    vertex_of_number_.resize(levels_.parts.numbers.size());
    for (Index v = 0; v < vertex_of_number_.size(); ++v)
        vertex_of_number_[levels_.parts.numbers[v]] = v;
    for (int depth = 0; depth <= levels_.steps(); ++depth)
        levels_.around.emplace_back(levels_.topology(depth));
    for (const MeshPoints& points : points_)
        touched_.push_back({{}, std::vector<bool>(points.size(), false)});
}

Result<std::unique_ptr<Model>> MeshModel::open(std::shared_ptr<const ByteSource> source) {
    RELIEF_TRY(codec::MeshFile file, codec::MeshFile::open(source));
    RELIEF_TRY(codec::MeshParts parts, file.parts());
    std::unique_ptr<MeshModel> model(
        new MeshModel(std::move(source), std::move(file), std::move(parts)));
    model->describe();
    RELIEF_CHECK(model->add_own_moves());
    return std::unique_ptr<Model>(std::move(model));
}

Result<std::unique_ptr<Model>> open_mesh(std::shared_ptr<const ByteSource> file) {
    return MeshModel::open(std::move(file));
}

void MeshModel::describe() {
    Description& d = description_;
    d.kind = Kind::Mesh;
    d.scheme = multires::mesh_scheme_name(file_.spec().scheme);
    for (int level = 0; level <= levels_.steps(); ++level) {
        const mesh::MeshCounts counts = file_.counts(level);
        d.levels.push_back({counts.vertices, counts.faces, file_.bytes_for(level), 0, 0});
    }
    d.components = 3;
    if (!file_.edited()) d.bound = file_.bound(0);
    d.bytes = file_.size();

    bounds_ = {points_.back()[0], points_.back()[0]};
    for (const Vec3<double>& p : points_.back()) include(bounds_, p);
    d.origin = 0.5 * (bounds_.min + bounds_.max);
    bounds_ = {bounds_.min - d.origin, bounds_.max - d.origin};
    const Vec3<double> size = bounds_.max - bounds_.min;
    levels_.tolerance = kTolerance * std::max({size.x, size.y, size.z});
}

/// Coarse ones first, as finer levels are made of what those leave.
Status MeshModel::add_own_moves() {
    MeshSpread spread(levels_);
    for (int depth = 0; depth <= levels_.steps(); ++depth) {
        MeshPoints deltas(points_[static_cast<std::size_t>(depth)].size());
        for (const codec::MeshMove& move : file_.moves())
            if (depth_of(move.level) == depth)
                deltas[vertex_of(depth, move.vertex)] +=
                    {move.delta[0], move.delta[1], move.delta[2]};
        std::vector<VertexChange> changes;
        for (Index v = 0; v < deltas.size(); ++v)
            if (!(deltas[v] == Vec3<double>())) changes.push_back({v, deltas[v]});
        RELIEF_TRY(const auto before, change(depth, std::move(changes), spread));
        spread = MeshSpread(levels_);
    }
    for (Touched& touched : touched_) {
        touched.vertices.clear();
        touched.is_touched.assign(touched.is_touched.size(), false);
    }
    original_ = points_;
    return {};
}

Index MeshModel::vertex_of(int depth, std::uint64_t point) const {
    return depth == levels_.steps() ? vertex_of_number_[point] : static_cast<Index>(point);
}

MeshDrawing MeshModel::drawing(int level, const std::vector<MeshPoints>& points) const {
    const auto depth = static_cast<std::size_t>(depth_of(level));
    MeshDrawing drawing{levels_.topology(depth_of(level)), levels_.around[depth], points[depth],
                        &original_[depth]};
    if (level == 0) drawing.numbers = levels_.parts.numbers;
    drawing.origin = description_.origin;
    return drawing;
}

std::unique_ptr<NetGraph> MeshModel::graph(int level) const {
    return std::make_unique<MeshGraph>(drawing(level, points_), vertex_of_number_);
}

Status MeshModel::check(const PointMove& move) const {
    if (move.slope.x != 0 || move.slope.y != 0)
        return wrong("control points of a mesh have no slope; move them");
    const auto small = [](double x) { return std::abs(x) <= codec::MeshMove::kLargest; };
    if (!small(move.delta.x) || !small(move.delta.y) || !small(move.delta.z))
        return wrong("a displacement is not a number of at most 1e150");
    return {};
}

void MeshModel::touch(std::size_t depth, Index v) {
    Touched& touched = touched_[depth];
    if (touched.is_touched[v]) return;
    touched.is_touched[v] = true;
    touched.vertices.push_back(v);
}

Result<std::vector<std::vector<MeshModel::Before>>> MeshModel::change(
    int depth, std::vector<VertexChange> changes, MeshSpread& spread) {
    RELIEF_TRY(const auto all, spread.spread(points_, depth, std::move(changes)));
    std::vector<std::vector<Before>> before(all.size());
    for (std::size_t d = 0; d < all.size(); ++d)
        for (const VertexChange& change : all[d]) {
            Vec3<double>& point = points_[d][change.vertex];
            before[d].push_back({change.vertex, point});
            point += change.delta;
            touch(d, change.vertex);
        }
    for (const VertexChange& change : all.back())
        include(bounds_, points_.back()[change.vertex] - description_.origin);
    return before;
}

/// Requires: moves of one level.
Status MeshModel::add(std::vector<PointMove> group, MeshSpread& spread) {
    const int depth = group.empty() ? levels_.steps() : depth_of(group.front().level);
    std::vector<VertexChange> changes;
    for (const PointMove& move : group)
        changes.push_back({vertex_of(depth, move.point), move.delta});
    RELIEF_TRY(auto before, change(depth, std::move(changes), spread));
    groups_.push_back({++last_id_, std::move(group), std::move(before)});
    return {};
}

Status MeshModel::push(std::vector<PointMove> group) {
    // With patches that no drag before has chosen: what is shown depends on the list alone.
    drag_.reset();
    MeshSpread spread(levels_);
    return add(std::move(group), spread);
}

Status MeshModel::drag(std::vector<PointMove> group) {
    if (!drag_ || drag_->state != state()) drag_ = Drag{state(), MeshSpread(levels_)};
    return add(std::move(group), drag_->spread);
}

void MeshModel::pop() {
    const std::vector<std::vector<Before>>& before = groups_.back().before;
    for (std::size_t d = 0; d < before.size(); ++d)
        for (const Before& was : before[d]) {
            points_[d][was.vertex] = was.point;
            touch(d, was.vertex);
        }
    groups_.pop_back();
}

Result<Change> MeshModel::changes(const View& view, const std::vector<TileName>&) {
    Change change;
    change.touched = touched_.back().vertices.size();
    change.surface.level = view.level;
    const std::vector<Index>& moved =
        touched_[static_cast<std::size_t>(depth_of(view.level))].vertices;
    if (view.show == View::Show::Edited) {
        change.surface = drawing(view.level, points_).patch(moved, view.extras);
        change.surface.level = view.level;
    }
    for (Touched& touched : touched_) {
        for (const Index v : touched.vertices) touched.is_touched[v] = false;
        touched.vertices.clear();
    }
    return change;
}

void MeshModel::add_uv(int level, SurfaceGeometry& out) const {
    for (const MeshAttribute& attribute : levels_.parts.attributes) {
        if (attribute.name != "uv" || attribute.face_varying() || attribute.components < 2)
            continue;
        for (Index v = 0; v < out.position.size(); ++v) {
            const Index at = level == 0 ? v : levels_.parts.numbers[v];
            const double* uv = attribute.element(at);
            out.uv.push_back({static_cast<float>(uv[0]), static_cast<float>(uv[1])});
        }
    }
}

MeshPoints MeshModel::original_by_number() const {
    MeshPoints points(vertex_of_number_.size());
    for (std::size_t k = 0; k < points.size(); ++k)
        points[k] = original_.back()[vertex_of_number_[k]];
    return points;
}

Result<SurfaceGeometry> MeshModel::compressed_surface(const View& view) const {
    RELIEF_TRY(const PolygonMesh decoded, compressed_->decode(view.level));
    RELIEF_TRY(const mesh::Topology mesh, topology_of(decoded));
    const VertexFaces around(mesh);
    const MeshPoints points = points_of(decoded);
    const MeshPoints original = original_by_number();
    MeshDrawing drawing{mesh, around, points, view.level == 0 ? &original : nullptr};
    drawing.origin = description_.origin;
    return drawing.surface(view.extras);
}

Result<SurfaceGeometry> MeshModel::surface(const View& view) const {
    const bool compressed = view.show == View::Show::Compressed && compressed_;
    const auto& points = view.show == View::Show::Original ? original_ : points_;
    RELIEF_TRY(SurfaceGeometry out, compressed ? compressed_surface(view)
                                               : drawing(view.level, points).surface(view.extras));
    out.level = view.level;
    if (!compressed) add_uv(view.level, out);
    return out;
}

Result<TileGeometry> MeshModel::tile(const View&, const TileName&) const {
    return wrong("a mesh has no tiles; it is drawn as a whole");
}

Result<NetGeometry> MeshModel::net(int level, const std::optional<LatticeBox>& window) const {
    if (window) return wrong("the control net of a mesh has no windows; ask for all of it");
    NetGeometry out = drawing(level, points_).net();
    out.level = level;
    return out;
}

Result<std::optional<Probe>> MeshModel::at(const View&, Vec2) const {
    return std::optional<Probe>();
}

Result<Bytes> MeshModel::file() const {
    std::vector<codec::MeshMove> moves;
    for (const Group& group : groups_)
        for (const PointMove& move : group.moves)
            moves.push_back({move.level, move.point, {move.delta.x, move.delta.y, move.delta.z}});
    RELIEF_TRY(Bytes bytes, read_all(*source_));
    return codec::add_mesh_moves(std::move(bytes), moves);
}

Result<Measurement> MeshModel::measure(const View& view) const {
    const bool compressed = view.show == View::Show::Compressed && compressed_;
    const auto depth = static_cast<std::size_t>(depth_of(compressed ? 0 : view.level));
    MeshPoints before = original_[depth];
    MeshPoints now = view.show == View::Show::Original ? before : points_[depth];
    if (compressed) {
        RELIEF_TRY(const PolygonMesh decoded, compressed_->decode(0));
        now = points_of(decoded);
        before = original_by_number();
    }
    Measurement worst;
    double squares = 0;
    for (std::size_t v = 0; v < now.size(); ++v) {
        const Vec3<double> off = now[v] - before[v];
        squares += dot(off, off);
        if (!(length(off) > worst.max_error)) continue;
        worst.max_error = length(off);
        worst.place = now[v] - description_.origin;
    }
    worst.rms_error = std::sqrt(squares / static_cast<double>(now.size()));
    return worst;
}

Result<Compression> MeshModel::compress(double max_error, const Progress& progress) {
    RELIEF_TRY(Bytes edited, file());
    RELIEF_TRY(const codec::MeshFile opened, codec::MeshFile::open(std::move(edited)));
    RELIEF_TRY(const PolygonMesh mesh, opened.decode(0));
    codec::MeshEncodeOptions options;
    options.goal = {codec::Goal::Kind::MaxError, max_error};
    options.scheme = file_.spec().scheme;
    options.levels = file_.levels();
    options.alpha = file_.spec().alpha;
    options.progress = progress;
    RELIEF_TRY(codec::EncodedMesh encoded, codec::encode_mesh(mesh, options));
    RELIEF_TRY(compressed_, codec::MeshFile::open(std::move(encoded.bytes)));
    const codec::MeshReport& report = encoded.report;
    return Compression{report.bytes, report.kept, report.coefficients, report.max_error,
                       report.rms_error};
}

}  // namespace relief::edit
