#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/header_parts.h"
#include "codec/quad_chunks.h"
#include "codec/quad_nodal.h"
#include "codec/quad_values.h"
#include "multires/fvs_functionals.h"

namespace relief::codec {

using mesh::Index;
using multires::fvs_mesh::Decomposition;
using multires::fvs_mesh::Hierarchy;
using multires::fvs_mesh::NodalData;
namespace fvs_mesh = multires::fvs_mesh;

namespace {

constexpr double kLargestRise = 1e150;

Error bad_file(std::string what, std::string where) {
    return {ErrorCode::BadFile, std::move(what), std::move(where)};
}

/// What is wrong with data that came from a file is wrong with the file.
template <class T>
Result<T> of_file(Result<T> result, const char* where) {
    if (result.ok()) return result;
    return bad_file(result.error().text() + "; the file is damaged", where);
}

}  // namespace

struct QuadFile::State {
    ContainerReader container;
    QuadHeader header;
    PlaneMesh base;
    mesh::Quadrangulation base_mesh;
    std::vector<QuadMove> moves;

    [[nodiscard]] QuadChunks chunks() const { return {header.levels}; }
    /// How often the base is refined at a level.
    [[nodiscard]] int refined(int level) const { return header.levels - level; }

    [[nodiscard]] Status check_header() const;
    [[nodiscard]] Status check_level(int level) const;
    [[nodiscard]] Status check_moves(const std::vector<QuadMove>& some) const;
    [[nodiscard]] Result<NodalData> decoded(const Hierarchy& hierarchy) const;
    [[nodiscard]] Result<Numbering> numbering(const mesh::Quadrangulation& mesh, int level) const;
    [[nodiscard]] Result<std::vector<double>> rises(const Hierarchy& hierarchy) const;
};

Status QuadFile::State::check_header() const {
    if (container.chunks().size() != chunks().count())
        return bad_file("the header calls for " + std::to_string(chunks().count()) +
                            " chunks, the file has " + std::to_string(container.chunks().size()),
                        "directory");
    if (is_plausible(header.vertices, container.complete_size()) &&
        is_plausible(header.quads, container.complete_size()))
        return {};
    return bad_file("claims a mesh of " + std::to_string(header.vertices) +
                        " vertices, for which the file is too small",
                    "header");
}

Status QuadFile::State::check_level(int level) const {
    if (level < 0 || level > header.levels)
        return Error{ErrorCode::InvalidArgument,
                     "there is no level " + std::to_string(level) + "; the file has levels 0 to " +
                         std::to_string(header.levels),
                     ""};
    return {};
}

Status QuadFile::State::check_moves(const std::vector<QuadMove>& some) const {
    for (const QuadMove& move : some) {
        RELIEF_CHECK(check_level(move.level));
        const std::uint64_t vertices = level_counts(base_mesh, refined(move.level))->vertices;
        if (move.vertex >= vertices)
            return Error{ErrorCode::InvalidArgument,
                         "vertex " + std::to_string(move.vertex) + " does not exist at level " +
                             std::to_string(move.level) + "; it has vertices 0 to " +
                             std::to_string(vertices - 1),
                         ""};
        if (!(std::abs(move.rise) <= kLargestRise))
            return Error{ErrorCode::InvalidArgument, "a move must be a number of at most 1e150",
                         ""};
    }
    return {};
}

/// The spline of the finest level of `hierarchy`, before moves.
Result<NodalData> QuadFile::State::decoded(const Hierarchy& hierarchy) const {
    std::optional<QuadValues> values;
    if (header.lattice) values.emplace(hierarchy, *header.lattice);
    QuadNodal nodal(hierarchy);
    Decomposition coefficients;
    for (int m = 0; m <= hierarchy.levels(); ++m) {
        RELIEF_TRY(const Bytes chunk, container.chunk(QuadChunks::level(m)));
        RELIEF_CHECK(values ? values->decode_next(chunk) : nodal.decode_next(chunk, coefficients));
    }
    if (values)
        return of_file(
            fvs_mesh::interpolate_values(hierarchy.mesh(hierarchy.levels()), values->values()),
            "levels");
    return of_file(fvs_mesh::reconstruct(hierarchy, coefficients, hierarchy.levels()), "levels");
}

/// Of the mesh of a level: only level 0 has numbers of its own.
Result<Numbering> QuadFile::State::numbering(const mesh::Quadrangulation& mesh, int level) const {
    const std::vector<Vec2> places = places_of(mesh, base.vertices, digits_of(header));
    Bytes chunk;
    if (level == 0) {
        RELIEF_TRY(chunk, container.chunk(chunks().numbering()));
    }
    return read_numbering(chunk, places, mesh.quads.size());
}

/// What moves add to the values at the vertices of the finest level of `hierarchy`: each level
/// follows the spline through what the levels below it add.
Result<std::vector<double>> QuadFile::State::rises(const Hierarchy& hierarchy) const {
    std::vector<double> rise(hierarchy.mesh(0).vertex_count());
    for (int m = 0; m <= hierarchy.levels(); ++m) {
        if (m > 0) {
            RELIEF_TRY(const auto below, fvs_mesh::interpolate_values(hierarchy.mesh(m - 1), rise));
            rise = fvs_mesh::predict(hierarchy.mesh(m - 1), below).value;
        }
        std::vector<Index> of_number;  // of the mesh, if it has other numbers
        for (const QuadMove& move : moves) {
            if (refined(move.level) != m) continue;
            if (m == header.levels && of_number.empty()) {
                RELIEF_TRY(const Numbering numbers, numbering(hierarchy.mesh(m), 0));
                of_number.resize(numbers.vertices.size());
                for (Index v = 0; v < of_number.size(); ++v) of_number[numbers.vertices[v]] = v;
            }
            rise[of_number.empty() ? move.vertex : of_number[move.vertex]] += move.rise;
        }
    }
    return rise;
}

QuadFile::QuadFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
QuadFile::QuadFile(QuadFile&&) noexcept = default;
QuadFile& QuadFile::operator=(QuadFile&&) noexcept = default;
QuadFile::~QuadFile() = default;

Result<QuadFile> QuadFile::open(Bytes bytes) {
    return open(std::make_shared<MemorySource>(std::move(bytes)));
}

Result<QuadFile> QuadFile::open(std::shared_ptr<const ByteSource> source, std::uint64_t visible) {
    auto state = std::make_unique<State>();
    RELIEF_TRY(state->container, ContainerReader::open(std::move(source), visible));
    RELIEF_TRY(state->header, read_quad_header(state->container.header()));
    const QuadHeader& header = state->header;
    RELIEF_CHECK(state->check_header());
    if (!state->container.complete(QuadChunks::kFirstLevel))
        return bad_file("not even the coarsest level is there; read more bytes",
                        "byte " + std::to_string(state->container.visible_size()));
    RELIEF_TRY(const Bytes mesh, state->container.chunk(QuadChunks::kMesh));
    RELIEF_TRY(state->base, read_mesh(mesh, header.vertices, header.quads, digits_of(header)));
    RELIEF_TRY(state->base_mesh,
               of_file(mesh::build(state->base.vertices, state->base.quads), "mesh chunk"));
    const auto finest = of_file(level_counts(state->base_mesh, header.levels), "header");
    if (!finest.ok()) return finest.error();
    if (!is_plausible(finest->vertices, state->container.complete_size()))
        return bad_file("claims levels of " + std::to_string(finest->vertices) +
                            " vertices, for which the file is too small",
                        "header");
    RELIEF_TRY(const Bytes edits, state->container.chunk(QuadChunks::kEdits));
    RELIEF_TRY(state->moves, read_quad_moves(edits));
    if (!state->check_moves(state->moves).ok())
        return bad_file("the edits are damaged", "edits chunk");
    return QuadFile(std::move(state));
}

int QuadFile::levels() const {
    return state_->header.levels;
}
Goal QuadFile::goal() const {
    return state_->header.goal;
}
bool QuadFile::holds_values() const {
    return state_->header.lattice.has_value();
}

std::string QuadFile::lattice() const {
    return holds_values() ? lattice_name(state_->header.lattice->kind) : "";
}

double QuadFile::step() const {
    if (!holds_values()) return 0;
    const ValueLattice& lattice = *state_->header.lattice;
    const bool even =
        lattice.kind == ValueLattice::Kind::Decimal || lattice.kind == ValueLattice::Kind::Step;
    return even ? lattice.value(1) : 0;
}

mesh::LevelCounts QuadFile::counts(int level) const {
    return *level_counts(state_->base_mesh, state_->refined(level));
}

std::array<double, 4> QuadFile::extent() const {
    std::array<double, 4> box = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (const Vec2& v : state_->base.vertices)
        box = {std::min(box[0], v.x), std::min(box[1], v.y), std::max(box[2], v.x),
               std::max(box[3], v.y)};
    return box;
}

double QuadFile::max_error() const {
    return state_->header.max_error;
}
double QuadFile::rms_error() const {
    return state_->header.rms_error;
}
int QuadFile::version() const {
    return kContainerVersion;
}
std::uint64_t QuadFile::size() const {
    return state_->container.complete_size();
}
bool QuadFile::checksums_ok() const {
    return state_->container.checksums_ok();
}
const std::vector<QuadMove>& QuadFile::moves() const {
    return state_->moves;
}

Status QuadFile::check(const std::vector<QuadMove>& more) const {
    return state_->check_moves(more);
}

int QuadFile::finest_level() const {
    const ContainerReader& container = state_->container;
    int level = container.complete(state_->chunks().numbering()) ? 0 : 1;
    while (level < levels() && !container.complete(QuadChunks::level(state_->refined(level))))
        ++level;
    return level;
}

std::uint64_t QuadFile::bytes_for(int level) const {
    const std::size_t last =
        level == 0 ? state_->chunks().numbering() : QuadChunks::level(state_->refined(level));
    const ChunkInfo& chunk = state_->container.chunks()[last];
    return chunk.offset + chunk.length;
}

std::vector<ChunkSummary> QuadFile::chunks() const {
    const auto& directory = state_->container.chunks();
    std::vector<ChunkSummary> list;
    const auto add = [&](const char* kind, int level, std::size_t k) {
        list.push_back({kind, level, 1, directory[k].length, directory[k].bound});
    };
    add("edits", 0, QuadChunks::kEdits);
    add("mesh", levels(), QuadChunks::kMesh);
    for (int level = levels(); level >= 0; --level)
        add("level", level, QuadChunks::level(state_->refined(level)));
    add("numbering", 0, state_->chunks().numbering());
    return list;
}

std::optional<double> QuadFile::bound(int level) const {
    if (edited() || (level != 0 && !holds_values())) return std::nullopt;
    return max_error();
}

std::optional<double> QuadFile::surface_bound(int level) const {
    if (edited()) return std::nullopt;
    if (level == 0) return state_->header.surface_error;
    return state_->container.chunks()[QuadChunks::level(state_->refined(level))].bound;
}

Result<QuadSurface> QuadFile::surface(int level) const {
    RELIEF_CHECK(state_->check_level(level));
    RELIEF_TRY(Hierarchy hierarchy, Hierarchy::create(state_->base_mesh, state_->refined(level)));
    RELIEF_TRY(NodalData data, state_->decoded(hierarchy));
    if (edited()) {
        RELIEF_TRY(const auto rises, of_file(state_->rises(hierarchy), "edits chunk"));
        const mesh::Quadrangulation& finest = hierarchy.mesh(hierarchy.levels());
        RELIEF_TRY(const NodalData moved,
                   of_file(fvs_mesh::interpolate_values(finest, rises), "edits chunk"));
        fvs_mesh::for_each_nodal(
            [](std::vector<double>& sum, const std::vector<double>& more) {
                for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += more[k];
            },
            data, moved);
    }
    return QuadSurface{std::move(hierarchy), std::move(data)};
}

Result<std::vector<Index>> QuadFile::vertex_numbers(int level) const {
    RELIEF_CHECK(state_->check_level(level));
    RELIEF_TRY(const Hierarchy hierarchy,
               Hierarchy::create(state_->base_mesh, state_->refined(level)));
    RELIEF_TRY(Numbering numbering, state_->numbering(hierarchy.mesh(hierarchy.levels()), level));
    return std::move(numbering.vertices);
}

Result<QuadMesh> QuadFile::decode(int level) const {
    RELIEF_CHECK(state_->check_level(level));
    if (level < finest_level())
        return bad_file("level " + std::to_string(level) + " needs the first " +
                            std::to_string(bytes_for(level)) +
                            " bytes of the file; read more, or a coarser level",
                        "byte " + std::to_string(state_->container.visible_size()));
    RELIEF_TRY(const QuadSurface surface, this->surface(level));
    const mesh::Quadrangulation& mesh = surface.hierarchy.mesh(surface.level());
    RELIEF_TRY(const Numbering numbering, state_->numbering(mesh, level));
    QuadMesh out;
    out.vertices.resize(mesh.vertex_count());
    out.quads.resize(mesh.quads.size());
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        out.vertices[numbering.vertices[v]] = {numbering.places[v].x, numbering.places[v].y,
                                               surface.data.value[v]};
    for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
        const auto [number, turn] = numbering.quads[q];
        for (std::size_t i = 0; i < 4; ++i)
            out.quads[number][(i + turn) % 4] = numbering.vertices[mesh.quads[q][i]];
    }
    return out;
}

Result<Bytes> add_quad_moves(Bytes file, const std::vector<QuadMove>& moves) {
    const auto source = std::make_shared<MemorySource>(std::move(file));
    RELIEF_TRY(const QuadFile opened, QuadFile::open(source));
    RELIEF_TRY(const ContainerReader container, ContainerReader::open(source));
    RELIEF_CHECK(opened.check(moves));
    std::vector<QuadMove> all = opened.moves();
    all.insert(all.end(), moves.begin(), moves.end());
    ContainerWriter writer;
    for (std::size_t k = 0; k < container.chunks().size(); ++k) {
        RELIEF_TRY(const Bytes chunk, container.chunk(k));
        writer.add(k == QuadChunks::kEdits ? write_quad_moves(all) : chunk,
                   container.chunks()[k].bound);
    }
    return writer.finish(container.header());
}

}  // namespace relief::codec
