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

struct QuadFile::State {
    ContainerReader container;
    QuadHeader header;
    PlaneMesh base;
    mesh::Quadrangulation base_mesh;
    std::vector<QuadMove> moves;

    [[nodiscard]] QuadChunks chunks() const { return QuadChunks(header.levels); }
    [[nodiscard]] int refined(int level) const { return chunks().refined(level); }

    [[nodiscard]] Status check_header() const;
    [[nodiscard]] Status check_moves(const std::vector<QuadMove>& some) const;
    [[nodiscard]] Result<NodalData> decoded(const Hierarchy& hierarchy) const;
    [[nodiscard]] Result<Numbering> numbering(const mesh::Quadrangulation& mesh, int level) const;
    [[nodiscard]] Result<std::vector<double>> rises(const Hierarchy& hierarchy) const;
};

Status QuadFile::State::check_header() const {
    RELIEF_CHECK(check_count(container, chunks()));
    RELIEF_CHECK(check_plausible(container, header.vertices, "vertices"));
    return check_plausible(container, header.quads, "quads");
}

Status QuadFile::State::check_moves(const std::vector<QuadMove>& some) const {
    for (const QuadMove& move : some) {
        RELIEF_CHECK(check_level(chunks(), move.level));
        const std::uint64_t vertices = level_counts(base_mesh, refined(move.level))->vertices;
        RELIEF_CHECK(check_move(move.level, move.vertex, vertices, std::array{move.rise}));
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
        RELIEF_TRY(const Bytes chunk, container.chunk(QuadChunks::of_refined(m)));
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
    RELIEF_CHECK(check_coarsest(state->container, QuadChunks::kFirstLevel));
    RELIEF_TRY(const Bytes mesh, state->container.chunk(QuadChunks::kBase));
    RELIEF_TRY(state->base, read_mesh(mesh, header.vertices, header.quads, digits_of(header)));
    RELIEF_TRY(state->base_mesh,
               of_file(mesh::build(state->base.vertices, state->base.quads), "mesh chunk"));
    const auto finest = of_file(level_counts(state->base_mesh, header.levels), "header");
    if (!finest.ok()) return finest.error();
    RELIEF_CHECK(check_plausible(state->container, finest->vertices, "vertices"));
    RELIEF_TRY(const Bytes edits, state->container.chunk(kEditsChunk));
    RELIEF_TRY(state->moves, read_quad_moves(edits));
    if (!state->check_moves(state->moves).ok()) return damaged_edits();
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
    return codec::finest_level(state_->container, state_->chunks());
}
std::uint64_t QuadFile::bytes_for(int level) const {
    return codec::bytes_for(state_->container, state_->chunks(), level);
}
std::vector<ChunkSummary> QuadFile::chunks() const {
    return summaries(state_->container, state_->chunks(),
                     {"mesh", "level", "level", {"numbering"}});
}

std::optional<double> QuadFile::bound(int level) const {
    if (edited() || (level != 0 && !holds_values())) return std::nullopt;
    return max_error();
}

std::optional<double> QuadFile::surface_bound(int level) const {
    if (edited()) return std::nullopt;
    if (level == 0) return state_->header.surface_error;
    return state_->container.chunks()[state_->chunks().of_level(level)].bound;
}

Result<QuadSurface> QuadFile::surface(int level) const {
    RELIEF_CHECK(check_level(state_->chunks(), level));
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
    RELIEF_CHECK(check_level(state_->chunks(), level));
    RELIEF_TRY(const Hierarchy hierarchy,
               Hierarchy::create(state_->base_mesh, state_->refined(level)));
    RELIEF_TRY(Numbering numbering, state_->numbering(hierarchy.mesh(hierarchy.levels()), level));
    return std::move(numbering.vertices);
}

Result<QuadMesh> QuadFile::decode(int level) const {
    RELIEF_CHECK(check_level(state_->chunks(), level));
    RELIEF_CHECK(check_complete(state_->container, state_->chunks(), level));
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
    return with_edits(container, write_quad_moves(all));
}

}  // namespace relief::codec
