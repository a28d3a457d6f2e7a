#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/mesh_coarse.h"
#include "codec/mesh_extras.h"
#include "codec/mesh_synthesis.h"
#include "relief/codec/container.h"

namespace relief::codec {

namespace {

using mesh::Index;

constexpr std::size_t kMoveBytes = 4 + 8 + 3 * 8;

Bytes write_moves(const std::vector<MeshMove>& moves) {
    ByteWriter out;
    for (const MeshMove& move : moves) {
        out.u32(static_cast<std::uint32_t>(move.level));
        out.u64(move.vertex);
        for (const double d : move.delta) out.f64(d);
    }
    return out.take();
}

Result<std::vector<MeshMove>> read_moves(std::span<const std::uint8_t> bytes) {
    return read_records<MeshMove>(bytes, kMoveBytes, [](ByteReader& in, MeshMove& move) {
        move.level = read_move_level(in);
        move.vertex = in.u64();
        for (double& d : move.delta) d = in.f64();
    });
}

}  // namespace

struct MeshFile::State {
    ContainerReader container;
    MeshHeader header;
    mesh::FaceList base_faces;
    std::vector<GridPoint> base_points;
    mesh::MeshCounts base_counts;
    multires::MeshTags tags;
    std::vector<MeshMove> moves;

    [[nodiscard]] MeshChunks numbers() const { return MeshChunks(header.levels); }
    [[nodiscard]] int depth(int level) const { return numbers().refined(level); }
    [[nodiscard]] mesh::MeshCounts counts(int depth) const {
        mesh::MeshCounts counts = base_counts;
        for (int step = 0; step < depth; ++step)
            counts = mesh::refined(counts, header.spec.split(step));
        return counts;
    }

    [[nodiscard]] Status read_base();
    [[nodiscard]] Status check_size() const;
    [[nodiscard]] Status check_moves(const std::vector<MeshMove>& some) const;
    [[nodiscard]] Result<MeshPoints> points(const MeshSynthesis& synthesis, int depth,
                                            const MeshOrder& order) const;
    [[nodiscard]] MeshPoints points_of_base() const;
    [[nodiscard]] Status make_exact(MeshPoints& points) const;
    [[nodiscard]] Result<MeshSynthesis> synthesis(int steps) const;
    void apply_moves(int depth, const MeshOrder& order, MeshPoints& points) const;
    [[nodiscard]] Result<PolygonMesh> finest(const MeshSynthesis& synthesis) const;
    [[nodiscard]] Result<PolygonMesh> coarser(const MeshSynthesis& synthesis, int depth) const;
    [[nodiscard]] Status read_named(const MeshHierarchy& hierarchy, const MeshOrder& order,
                                    PolygonMesh& mesh) const;
    /// There are attributes or labels, and they have been read.
    [[nodiscard]] bool knows_names() const {
        return (!header.attributes.empty() || !header.labels.empty()) &&
               container.complete(numbers().labels());
    }
};

Status MeshFile::State::read_base() {
    RELIEF_TRY(const Bytes chunk, container.chunk(MeshChunks::kBase));
    ByteReader in(chunk);
    const auto connectivity = in.take(in.varint());
    if (in.failed()) return bad_file("it is cut off; the file is damaged", "base chunk");
    RELIEF_TRY(BaseMesh coded,
               decode_base(connectivity, header.sides, header.base_vertices, header.base_faces));
    RELIEF_TRY(BaseMesh base, in_own_order(in.rest(), std::move(coded)));
    RELIEF_TRY(
        const mesh::Topology built,
        of_file(mesh::build(base.faces, static_cast<Index>(base.points.size())), "base chunk"));
    if (built.sides != header.sides && header.sides != 0)
        return bad_file("its faces are not those of the header; the file is damaged", "base chunk");
    base_counts = mesh::counts_of(built);
    base_faces = std::move(base.faces);
    base_points = std::move(base.points);
    RELIEF_TRY(const Bytes marks, container.chunk(MeshChunks::kTags));
    RELIEF_TRY(tags, read_tags(marks, built));
    return {};
}

Status MeshFile::State::check_size() const {
    for (int d = 0; d <= header.levels; ++d) {
        const mesh::MeshCounts here = counts(d);
        RELIEF_CHECK(check_plausible(container, here.vertices, "vertices"));
        if (!mesh::check_size(here).ok())
            return bad_file("claims more levels than there can be; the file is damaged", "header");
    }
    return {};
}

Status MeshFile::State::check_moves(const std::vector<MeshMove>& some) const {
    for (const MeshMove& move : some) {
        RELIEF_CHECK(check_level(numbers(), move.level));
        const std::uint64_t vertices = counts(depth(move.level)).vertices;
        RELIEF_CHECK(check_move(move.level, move.vertex, vertices, move.delta));
    }
    return {};
}

void MeshFile::State::apply_moves(int at, const MeshOrder& order, MeshPoints& points) const {
    std::vector<Index> of_number;
    if (at == header.levels && !order.vertices.empty()) {
        of_number.resize(order.vertices.size());
        for (Index v = 0; v < of_number.size(); ++v) of_number[order.vertices[v]] = v;
    }
    for (const MeshMove& move : moves) {
        if (depth(move.level) != at) continue;
        const std::size_t v = of_number.empty() ? move.vertex : of_number[move.vertex];
        points[v] += {move.delta[0], move.delta[1], move.delta[2]};
    }
}

MeshPoints MeshFile::State::points_of_base() const {
    MeshPoints points;
    for (const GridPoint& p : base_points)
        points.push_back(base_point(header.quantisation, header.levels, p));
    return points;
}

/// Of the finest level.
Status MeshFile::State::make_exact(MeshPoints& points) const {
    if (!header.lattice) return {};
    RELIEF_TRY(const Bytes chunk, container.chunk(numbers().exact()));
    return read_exact(chunk, *header.lattice, points);
}

/// order: of the finest level, whose moves count its numbers.
Result<MeshPoints> MeshFile::State::points(const MeshSynthesis& synthesis, int depth_wanted,
                                           const MeshOrder& order) const {
    MeshPoints points = points_of_base();
    MeshPoints moved;
    if (!moves.empty()) {
        moved = points;
        apply_moves(0, order, moved);
    }
    MeshDetails details(synthesis.hierarchy());
    for (int step = 0; step < depth_wanted; ++step) {
        RELIEF_TRY(const Bytes chunk, container.chunk(MeshChunks::step(step)));
        RELIEF_TRY(const QuantisedStep coded, details.decode_next(chunk));
        const MeshQuantisation& q = header.quantisation;
        const multires::DetailFrames frames(synthesis.hierarchy(), step, points.data());
        synthesis.refine(q, header.levels, step, coded, frames, points);
        if (moves.empty()) continue;
        synthesis.refine_moved(step, local_details(q, header.levels, step, coded, frames), moved);
        apply_moves(step + 1, order, moved);
    }
    if (!header.lattice || depth_wanted < header.levels) return moves.empty() ? points : moved;
    MeshPoints exact = points;
    RELIEF_CHECK(make_exact(exact));
    if (moves.empty()) return exact;
    for (std::size_t v = 0; v < exact.size(); ++v) moved[v] += exact[v] - points[v];
    return moved;
}

namespace {

void add_faces(const mesh::FaceList& faces, PolygonMesh& mesh) {
    mesh.offsets = faces.offsets;
    mesh.corners.assign(faces.corners.begin(), faces.corners.end());
}

Status check_points(const MeshPoints& points) {
    for (std::size_t v = 0; v < points.size(); ++v) {
        const Vec3<double>& p = points[v];
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            return bad_file("a vertex is not a point; the file is damaged or was moved too far",
                            "vertex " + std::to_string(v));
    }
    return {};
}

Status set_points(const MeshPoints& points, const std::vector<Index>& numbers, PolygonMesh& mesh) {
    RELIEF_CHECK(check_points(points));
    mesh.vertices.resize(points.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
        const Vec3<double>& p = points[v];
        mesh.vertices[numbers.empty() ? v : numbers[v]] = {p.x, p.y, p.z};
    }
    return {};
}

}  // namespace

Result<PolygonMesh> MeshFile::State::finest(const MeshSynthesis& synthesis) const {
    const mesh::Topology& mesh = synthesis.hierarchy().topology(header.levels);
    RELIEF_TRY(const Bytes order_chunk, container.chunk(numbers().order()));
    RELIEF_TRY(const MeshOrder order, read_order(order_chunk, synthesis.hierarchy()));
    RELIEF_TRY(const MeshPoints places, points(synthesis, header.levels, order));
    PolygonMesh result;
    result.libraries = header.libraries;
    RELIEF_CHECK(set_points(places, order.vertices, result));
    const auto sides = static_cast<Index>(mesh.sides);
    result.corners.resize(mesh.half_edge_count());
    for (Index f = 0; f < mesh.face_count; ++f)
        for (Index k = 0; k < sides; ++k) {
            const Index first = order.corners[f];
            const Index corner = first / sides * sides + (first % sides + k) % sides;
            result.corners[corner] =
                static_cast<std::int32_t>(order.vertices[mesh.origin[sides * f + k]]);
        }
    for (Index f = 1; f <= mesh.face_count; ++f) result.offsets.push_back(std::int64_t{sides} * f);
    RELIEF_CHECK(read_named(synthesis.hierarchy(), order, result));
    RELIEF_TRY(const Bytes creases, container.chunk(numbers().creases()));
    if (creases == Bytes{kCreasesOfTags})
        add_creases(synthesis.hierarchy(), header.levels, tags.corner, result);
    else
        RELIEF_CHECK(read_creases(creases, result));
    if (const Status checked = relief::check(result); !checked.ok())
        return bad_file(checked.error().text() + "; the file is damaged", "mesh");
    return result;
}

/// Attributes and labels, in the numbers of the mesh.
Status MeshFile::State::read_named(const MeshHierarchy& hierarchy, const MeshOrder& order,
                                   PolygonMesh& mesh) const {
    RELIEF_TRY(const Bytes attributes, container.chunk(numbers().attributes()));
    RELIEF_TRY(mesh.attributes, read_attributes(attributes, header.attributes, hierarchy, order));
    mesh.labels = header.labels;
    RELIEF_TRY(const Bytes labels, container.chunk(numbers().labels()));
    const auto sides = static_cast<Index>(hierarchy.topology(header.levels).sides);
    return read_labels(labels, order, sides, mesh.labels);
}

/// In the numbers of the hierarchy; sharp edges are those of the transform.
Result<PolygonMesh> MeshFile::State::coarser(const MeshSynthesis& synthesis, int at) const {
    RELIEF_TRY(const MeshPoints places, points(synthesis, at, {}));
    PolygonMesh result;
    result.libraries = header.libraries;
    RELIEF_CHECK(set_points(places, {}, result));
    const mesh::Topology& mesh = synthesis.hierarchy().topology(at);
    add_faces(mesh::faces_of(mesh), result);
    add_creases(synthesis.hierarchy(), at, synthesis.hierarchy().tags(at).corner, result);
    if (!knows_names()) return result;
    const MeshHierarchy& hierarchy = synthesis.hierarchy();
    RELIEF_TRY(const Bytes order_chunk, container.chunk(numbers().order()));
    RELIEF_TRY(const MeshOrder order, read_order(order_chunk, hierarchy));
    PolygonMesh finest;
    RELIEF_CHECK(read_named(hierarchy, order, finest));
    take_coarse_extras(finest, order, hierarchy, at, result);
    if (const Status checked = relief::check(result); !checked.ok())
        return bad_file(checked.error().text() + "; the file is damaged", "mesh");
    return result;
}

MeshFile::MeshFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
MeshFile::MeshFile(MeshFile&&) noexcept = default;
MeshFile& MeshFile::operator=(MeshFile&&) noexcept = default;
MeshFile::~MeshFile() = default;

Result<MeshFile> MeshFile::open(Bytes bytes) {
    return open(std::make_shared<MemorySource>(std::move(bytes)));
}

Result<MeshFile> MeshFile::open(std::shared_ptr<const ByteSource> source, std::uint64_t visible) {
    auto state = std::make_unique<State>();
    RELIEF_TRY(state->container, ContainerReader::open(std::move(source), visible));
    RELIEF_TRY(state->header, read_mesh_header(state->container.header()));
    const ContainerReader& container = state->container;
    RELIEF_CHECK(check_count(container, state->numbers()));
    RELIEF_CHECK(check_plausible(container, state->header.base_vertices, "vertices"));
    RELIEF_CHECK(check_plausible(container, state->header.base_faces, "faces"));
    RELIEF_CHECK(check_coarsest(container, MeshChunks::kTags));
    RELIEF_CHECK(state->read_base());
    RELIEF_CHECK(state->check_size());
    RELIEF_TRY(const Bytes edits, container.chunk(kEditsChunk));
    RELIEF_TRY(state->moves, read_moves(edits));
    if (!state->check_moves(state->moves).ok()) return damaged_edits();
    return MeshFile(std::move(state));
}

const multires::MeshSpec& MeshFile::spec() const {
    return state_->header.spec;
}
int MeshFile::levels() const {
    return state_->header.levels;
}
Goal MeshFile::goal() const {
    return state_->header.goal;
}
bool MeshFile::lossless() const {
    return state_->header.lattice.has_value();
}
double MeshFile::step() const {
    return state_->header.quantisation.step;
}
mesh::MeshCounts MeshFile::counts(int level) const {
    return state_->counts(state_->depth(level));
}
MeshDistance MeshFile::distance() const {
    return state_->header.distance;
}
double MeshFile::max_error() const {
    return state_->header.max_error;
}
double MeshFile::rms_error() const {
    return state_->header.rms_error;
}
int MeshFile::version() const {
    return kContainerVersion;
}
std::uint64_t MeshFile::size() const {
    return state_->container.complete_size();
}
bool MeshFile::checksums_ok() const {
    return state_->container.complete_chunks() == state_->container.chunks().size() &&
           state_->container.checksums_ok();
}
const std::vector<MeshMove>& MeshFile::moves() const {
    return state_->moves;
}
Status MeshFile::check(const std::vector<MeshMove>& more) const {
    return state_->check_moves(more);
}

int MeshFile::finest_level() const {
    return codec::finest_level(state_->container, state_->numbers());
}
std::uint64_t MeshFile::bytes_for(int level) const {
    return codec::bytes_for(state_->container, state_->numbers(), level);
}
std::vector<ChunkSummary> MeshFile::chunks() const {
    std::vector<ChunkSummary> list = summaries(
        state_->container, state_->numbers(),
        {"base", "tags", "details", {"order", "exact", "attributes", "labels", "creases"}});
    std::erase_if(list, [](const ChunkSummary& chunk) { return chunk.bytes == 0; });
    return list;
}

std::optional<double> MeshFile::bound(int level) const {
    if (level != 0 || edited()) return {};
    return goal().kind == Goal::Kind::MaxError ? goal().value : max_error();
}

Result<MeshSynthesis> MeshFile::State::synthesis(int steps) const {
    RELIEF_TRY(mesh::Topology base,
               mesh::build(base_faces, static_cast<Index>(base_points.size())));
    return of_file(MeshSynthesis::create(std::move(base), tags, header, steps), "base chunk");
}

Result<PolygonMesh> MeshFile::decode(int level) const {
    RELIEF_CHECK(check_level(state_->numbers(), level));
    const int depth = state_->depth(level);
    RELIEF_TRY(const MeshSynthesis synthesis,
               state_->synthesis(state_->knows_names() ? levels() : depth));
    return level == 0 ? state_->finest(synthesis) : state_->coarser(synthesis, depth);
}

Result<MeshParts> MeshFile::parts() const {
    const MeshHeader& header = state_->header;
    const ContainerReader& container = state_->container;
    RELIEF_TRY(MeshSynthesis synthesis, state_->synthesis(levels()));
    MeshParts parts;
    parts.transform = synthesis.transform();
    parts.points.push_back(state_->points_of_base());
    MeshDetails details(synthesis.hierarchy());
    for (int step = 0; step < levels(); ++step) {
        RELIEF_TRY(const Bytes chunk, container.chunk(MeshChunks::step(step)));
        RELIEF_TRY(const QuantisedStep coded, details.decode_next(chunk));
        MeshPoints points = parts.points.back();
        const multires::DetailFrames frames(synthesis.hierarchy(), step, points.data());
        synthesis.refine(header.quantisation, levels(), step, coded, frames, points);
        parts.details.push_back(local_details(header.quantisation, levels(), step, coded, frames));
        parts.points.push_back(std::move(points));
    }
    RELIEF_CHECK(state_->make_exact(parts.points.back()));
    for (const MeshPoints& points : parts.points) RELIEF_CHECK(check_points(points));
    RELIEF_TRY(const Bytes order_chunk, container.chunk(state_->numbers().order()));
    RELIEF_TRY(MeshOrder order, read_order(order_chunk, synthesis.hierarchy()));
    RELIEF_TRY(const Bytes attributes, container.chunk(state_->numbers().attributes()));
    RELIEF_TRY(parts.attributes,
               read_attributes(attributes, header.attributes, synthesis.hierarchy(), order));
    parts.numbers = std::move(order.vertices);
    parts.hierarchy = std::move(synthesis).take_hierarchy();
    return parts;
}

Result<Bytes> add_mesh_moves(Bytes file, const std::vector<MeshMove>& moves) {
    const auto source = std::make_shared<MemorySource>(std::move(file));
    RELIEF_TRY(const MeshFile opened, MeshFile::open(source));
    RELIEF_CHECK(opened.check(moves));
    std::vector<MeshMove> all = opened.moves();
    all.insert(all.end(), moves.begin(), moves.end());
    RELIEF_TRY(const ContainerReader reader, ContainerReader::open(source));
    return with_edits(reader, write_moves(all));
}

}  // namespace relief::codec
