#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/ps_chunks.h"
#include "relief/codec/container.h"

namespace relief::codec {

namespace ps = multires::ps;
using mesh::Index;

struct PsFile::State {
    ContainerReader container;
    PsHeader header;
    mesh::Triangulation base;
    std::vector<PsMove> moves;

    [[nodiscard]] PsChunks chunks() const { return PsChunks(header.levels); }
    [[nodiscard]] int refined(int level) const { return chunks().refined(level); }
    [[nodiscard]] std::size_t components() const {
        return static_cast<std::size_t>(header.components);
    }

    [[nodiscard]] Status check_sizes() const;
    [[nodiscard]] Status check_moves(const std::vector<PsMove>& some) const;
    [[nodiscard]] Result<VertexValues> values() const;
    [[nodiscard]] Result<LevelHeights> decoded(const ps::Hierarchy& hierarchy) const;
    [[nodiscard]] ps::Coefficients risen(const ps::Hierarchy& hierarchy, int component) const;
};

Status PsFile::State::check_sizes() const {
    RELIEF_CHECK(check_count(container, chunks()));
    if (header.base.triangles > 2 * header.base.vertices)
        return bad_file("claims more triangles than its vertices can have; the file is damaged",
                        "header");
    return check_plausible(container, header.base.vertices, "vertices");
}

Status PsFile::State::check_moves(const std::vector<PsMove>& some) const {
    for (const PsMove& move : some) {
        RELIEF_CHECK(check_level(chunks(), move.level));
        const std::uint64_t vertices = level_counts(base, refined(move.level)).vertices;
        RELIEF_CHECK(check_move(move.level, move.vertex, vertices,
                                std::array{move.rise, move.tilt.x, move.tilt.y}));
        if (move.component < 0 || move.component >= header.components)
            return bad_argument("there is no component " + std::to_string(move.component) +
                                "; the file has components 0 to " +
                                std::to_string(header.components - 1));
    }
    return {};
}

Result<VertexValues> PsFile::State::values() const {
    RELIEF_TRY(const Bytes chunk, container.chunk(PsChunks::of_refined(0)));
    return decode_ps_values(base, header.lattices, chunk);
}

/// The splines of the finest level of `hierarchy`, before moves.
Result<LevelHeights> PsFile::State::decoded(const ps::Hierarchy& hierarchy) const {
    if (header.gradients) {
        RELIEF_TRY(const VertexValues all, values());
        return of_file(splines_through(hierarchy.space(0), all, *header.gradients), "level 0");
    }
    PsLevels coder(hierarchy, level_counts(base, header.levels).vertices, header.quantisation);
    std::vector<ps::Decomposition> splines(components());
    for (int m = 0; m <= hierarchy.levels(); ++m) {
        const std::size_t old = m == 0 ? 0 : hierarchy.space(m - 1).mesh.x.size();
        LevelHeights heights(components(),
                             ps::Coefficients(hierarchy.space(m).mesh.x.size() - old));
        RELIEF_TRY(const Bytes chunk, container.chunk(PsChunks::of_refined(m)));
        RELIEF_CHECK(coder.decode_next(chunk, heights));
        for (std::size_t c = 0; c < splines.size(); ++c) {
            if (m == 0)
                splines[c].base = std::move(heights[c]);
            else
                splines[c].details.push_back(std::move(heights[c]));
        }
    }
    LevelHeights finest;
    for (ps::Decomposition& spline : splines) {
        RELIEF_TRY(
            ps::Coefficients heights,
            of_file(synthesise(hierarchy, spline, hierarchy.levels(), header.quantisation.update),
                    "levels"));
        finest.push_back(std::move(heights));
    }
    if (hierarchy.levels() < header.levels || header.lattices.empty()) return finest;
    RELIEF_TRY(const Bytes chunk, container.chunk(chunks().correction()));
    RELIEF_CHECK(read_exact_heights(chunk, header.lattices, finest));
    return finest;
}

/// What moves add to a component on the finest level of `hierarchy`.
ps::Coefficients PsFile::State::risen(const ps::Hierarchy& hierarchy, int component) const {
    ps::Coefficients sum(hierarchy.space(0).mesh.x.size());
    for (int m = 0; m <= hierarchy.levels(); ++m) {
        if (m > 0) sum = prolong(hierarchy.space(m - 1), hierarchy.step(m - 1), sum);
        for (const PsMove& move : moves) {
            if (refined(move.level) != m || move.component != component) continue;
            const auto v = static_cast<std::size_t>(move.vertex);
            const ps::Heights rise =
                ps::heights(hierarchy.space(m).control[v], {move.rise, move.tilt});
            for (std::size_t j = 0; j < 3; ++j) sum[v][j] += rise[j];
        }
    }
    return sum;
}

PsFile::PsFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
PsFile::PsFile(PsFile&&) noexcept = default;
PsFile& PsFile::operator=(PsFile&&) noexcept = default;
PsFile::~PsFile() = default;

Result<PsFile> PsFile::open(Bytes bytes) {
    return open(std::make_shared<MemorySource>(std::move(bytes)));
}

Result<PsFile> PsFile::open(std::shared_ptr<const ByteSource> source, std::uint64_t visible) {
    auto state = std::make_unique<State>();
    RELIEF_TRY(state->container, ContainerReader::open(std::move(source), visible));
    const ContainerReader& container = state->container;
    RELIEF_TRY(state->header, read_ps_header(container.header()));
    RELIEF_CHECK(state->check_sizes());
    const PsChunks chunks = state->chunks();
    RELIEF_CHECK(check_coarsest(container, chunks.last_of(chunks.levels)));
    RELIEF_TRY(const Bytes mesh, container.chunk(PsChunks::kBase));
    RELIEF_TRY(state->base, decode_ps_base(mesh, state->header.base));
    const std::uint64_t finest = level_counts(state->base, chunks.levels).vertices;
    RELIEF_CHECK(check_plausible(container, finest, "vertices"));
    RELIEF_TRY(const Bytes edits, container.chunk(kEditsChunk));
    RELIEF_TRY(state->moves, read_ps_moves(edits));
    if (!state->check_moves(state->moves).ok()) return damaged_edits();
    return PsFile(std::move(state));
}

int PsFile::levels() const {
    return state_->header.levels;
}
int PsFile::components() const {
    return state_->header.components;
}
Goal PsFile::goal() const {
    return state_->header.goal;
}
const PsReference& PsFile::reference() const {
    return state_->header.reference;
}
bool PsFile::holds_values() const {
    return state_->header.gradients.has_value();
}
bool PsFile::lossless() const {
    return state_->header.surface_error == 0;
}
bool PsFile::delaunay() const {
    return state_->header.base.peel.has_value();
}

PsCounts PsFile::counts(int level) const {
    const PsLevelCounts counts = level_counts(state_->base, state_->refined(level));
    return {counts.vertices, counts.triangles};
}

std::array<double, 4> PsFile::extent() const {
    const mesh::Triangulation& base = state_->base;
    const auto [left, right] = std::minmax_element(base.x.begin(), base.x.end());
    const auto [bottom, top] = std::minmax_element(base.y.begin(), base.y.end());
    return {base.origin.x + *left, base.origin.y + *bottom, base.origin.x + *right,
            base.origin.y + *top};
}

double PsFile::max_error() const {
    return state_->header.max_error;
}
double PsFile::rms_error() const {
    return state_->header.rms_error;
}
int PsFile::version() const {
    return kContainerVersion;
}
std::uint64_t PsFile::size() const {
    return state_->container.complete_size();
}
bool PsFile::checksums_ok() const {
    return state_->container.checksums_ok();
}
const std::vector<PsMove>& PsFile::moves() const {
    return state_->moves;
}
const mesh::Triangulation& PsFile::base() const {
    return state_->base;
}

Status PsFile::check(const std::vector<PsMove>& more) const {
    return state_->check_moves(more);
}

int PsFile::finest_level() const {
    return codec::finest_level(state_->container, state_->chunks());
}
std::uint64_t PsFile::bytes_for(int level) const {
    return codec::bytes_for(state_->container, state_->chunks(), level);
}
std::vector<ChunkSummary> PsFile::chunks() const {
    return summaries(state_->container, state_->chunks(),
                     {"mesh", "level", "level", {"correction"}});
}

std::optional<double> PsFile::bound(int level) const {
    if (edited() || level != 0) return std::nullopt;
    return max_error();
}

std::optional<double> PsFile::surface_bound(int level) const {
    if (edited()) return std::nullopt;
    if (level == 0) return state_->header.surface_error;
    return state_->container.chunks()[state_->chunks().of_level(level)].bound;
}

Result<PsValues> PsFile::values() const {
    if (!holds_values()) return bad_argument("the file holds coefficients, not values at vertices");
    RELIEF_TRY(VertexValues components, state_->values());
    return PsValues{std::move(components), *state_->header.gradients};
}

Result<PsSurface> PsFile::surface(int level) const {
    RELIEF_CHECK(check_level(state_->chunks(), level));
    RELIEF_CHECK(check_complete(state_->container, state_->chunks(), level));
    RELIEF_TRY(ps::Space space, of_file(ps::make_space(state_->base), "mesh chunk"));
    RELIEF_TRY(
        const ps::Hierarchy hierarchy,
        of_file(ps::Hierarchy::create(std::move(space), state_->refined(level)), "mesh chunk"));
    PsSurface surface;
    RELIEF_TRY(surface.components, state_->decoded(hierarchy));
    surface.space = hierarchy.space(hierarchy.levels());
    if (!edited()) return surface;
    for (int c = 0; c < components(); ++c) {
        const ps::Coefficients rise = state_->risen(hierarchy, c);
        ps::Coefficients& heights = surface.components[static_cast<std::size_t>(c)];
        for (std::size_t v = 0; v < heights.size(); ++v)
            for (std::size_t j = 0; j < 3; ++j) heights[v][j] += rise[v][j];
    }
    return surface;
}

Result<Bytes> add_ps_moves(Bytes file, const std::vector<PsMove>& moves) {
    const auto source = std::make_shared<MemorySource>(std::move(file));
    RELIEF_TRY(const PsFile opened, PsFile::open(source));
    RELIEF_TRY(const ContainerReader container, ContainerReader::open(source));
    RELIEF_CHECK(opened.check(moves));
    std::vector<PsMove> all = opened.moves();
    all.insert(all.end(), moves.begin(), moves.end());
    return with_edits(container, write_ps_moves(all));
}

}  // namespace relief::codec
