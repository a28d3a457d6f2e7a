#include <algorithm>
#include <cmath>
#include <string>

#include "codec/bytes.h"
#include "codec/corrections.h"
#include "codec/level_chunks.h"
#include "codec/raster_header.h"
#include "relief/codec/container.h"
#include "relief/codec/mask_coder.h"
#include "relief/codec/quantise.h"
#include "relief/codec/raster_codec.h"
#include "relief/core/parallel.h"
#include "relief/spline/lattice_filters.h"

namespace relief::codec {

using multires::LevelCoefficients;
using multires::Move;
using multires::Planes;

namespace {

constexpr std::uint64_t kMoveBytes = 4 + 2 * 8 + 4 * 8;
constexpr double kLargestMove = 1e300;

/// Samples that a header may claim: any raster of some size, or so many a byte that only one
/// without content has more.
constexpr std::uint64_t kSamplesAlways = std::uint64_t{1} << 28;
constexpr std::uint64_t kSamplesPerByte = std::uint64_t{1} << 16;

/// Sizes are believed before anything of their size is allocated, so they must be believable.
Status check_size(const Raster& description, int components, std::uint64_t file_size) {
    const auto samples =
        static_cast<std::uint64_t>(description.rows) * static_cast<std::uint64_t>(description.cols);
    const std::uint64_t bytes = std::min(file_size, std::uint64_t{1} << 40);
    const std::uint64_t most = std::max(kSamplesAlways, kSamplesPerByte * bytes);
    if (samples <= most / static_cast<std::uint64_t>(components)) return {};
    return Error{ErrorCode::BadFile,
                 "claims " + std::to_string(description.cols) + " x " +
                     std::to_string(description.rows) + " samples, too many for " +
                     std::to_string(file_size) + " bytes; the file is damaged",
                 "header"};
}

bool is_displacement(const Move& move) {
    return std::all_of(move.delta.begin(), move.delta.end(),
                       [](double d) { return std::abs(d) <= kLargestMove; });
}

std::vector<std::uint8_t> write_moves(const std::vector<Move>& moves) {
    ByteWriter out;
    out.u64(moves.size());
    for (const Move& move : moves) {
        out.u32(static_cast<std::uint32_t>(move.level));
        out.i64(move.row);
        out.i64(move.col);
        for (const double delta : move.delta) out.f64(delta);
    }
    return out.take();
}

Result<std::vector<Move>> read_moves(std::span<const std::uint8_t> bytes,
                                     const PyramidLayout& layout) {
    const Error damaged{ErrorCode::BadFile, "the edits are damaged", "edit chunk"};
    ByteReader in(bytes);
    const std::uint64_t count = in.u64();
    if (in.failed() || in.rest().size() % kMoveBytes != 0 || count != in.rest().size() / kMoveBytes)
        return damaged;
    std::vector<Move> moves(count);
    for (Move& move : moves) {
        move.level = static_cast<int>(std::min<std::uint32_t>(in.u32(), 1000));
        move.row = in.i64();
        move.col = in.i64();
        for (double& delta : move.delta) delta = in.f64();
        if (!is_displacement(move) || !multires::check_move(layout, move).ok()) return damaged;
    }
    return moves;
}

void add(Planes<double>& to, const Planes<double>& from) {
    for (std::size_t p = 0; p < to.size(); ++p)
        for (std::int64_t r = 0; r < to[p].rows(); ++r)
            for (std::int64_t c = 0; c < to[p].cols(); ++c) to[p](r, c) += from[p](r, c);
}

bool all_finite(const Planes<double>& planes) {
    return std::all_of(planes.begin(), planes.end(), [](const Grid<double>& plane) {
        for (std::int64_t r = 0; r < plane.rows(); ++r)
            if (!std::all_of(plane.row(r), plane.row(r) + plane.cols(),
                             [](double v) { return std::isfinite(v); }))
                return false;
        return true;
    });
}

/// The georeference of every 2^level-th sample: centres stay where they are.
GeoReference georeference_of(GeoReference geo, int level) {
    if (!geo.transform || level == 0) return geo;
    auto& t = *geo.transform;
    const double step = std::ldexp(1.0, level);
    // Centre of the first sample, then half a new cell back.
    t[0] += 0.5 * (1 - step) * (t[1] + t[2]);
    t[3] += 0.5 * (1 - step) * (t[4] + t[5]);
    for (const std::size_t k : {1U, 2U, 4U, 5U}) t[k] *= step;
    return geo;
}

}  // namespace

struct RasterFile::State {
    std::vector<std::uint8_t> bytes;
    std::optional<ContainerReader> container;
    RasterHeader header;
    PyramidLayout layout;
    Grid<std::uint8_t> mask;
    std::vector<Move> moves;
    // Places in the container's directory.
    std::vector<std::size_t> level_chunks;  ///< scaling, details L, .. details 1
    std::optional<std::size_t> correction_chunk;
    std::optional<std::size_t> mask_chunk;
    std::optional<std::size_t> edits_chunk;
    int complete_levels = 0;  ///< leading level chunks inside the prefix
    std::vector<float> steps;

    Status read_structure(std::uint64_t file_size);
    Status find_chunks();
    Status read_side_data();
    [[nodiscard]] Result<Quantised> read_bands(int level) const;
    [[nodiscard]] Result<LevelCoefficients<double>> base_coefficients(int level) const;
    /// Samples of `level` with corrections, without moves, not rounded.
    [[nodiscard]] Result<Planes<double>> corrected_samples(int level) const;
};

Status RasterFile::State::read_structure(std::uint64_t file_size) {
    RELIEF_TRY(header, read_header(container->header()));
    RELIEF_CHECK(check_size(header.description, header.components, file_size));
    auto bands = multires::layout(header.spec, header.description.rows, header.description.cols,
                                  header.components);
    if (!bands.ok())
        return Error{ErrorCode::BadFile,
                     "describes an impossible pyramid: " + bands.error().message, "header"};
    layout = *std::move(bands);
    return find_chunks();
}

Status RasterFile::State::find_chunks() {
    const auto wrong = [](const char* what) {
        return Error{ErrorCode::BadFile, std::string(what) + "; the file is damaged", "directory"};
    };
    std::vector<std::optional<std::size_t>> levels(static_cast<std::size_t>(layout.levels() + 1));
    for (std::size_t k = 0; k < container->chunks().size(); ++k) {
        const ChunkInfo& chunk = container->chunks()[k];
        std::optional<std::size_t>* place = nullptr;
        if (chunk.kind == ChunkKind::Mask) place = &mask_chunk;
        if (chunk.kind == ChunkKind::Edits) place = &edits_chunk;
        if (chunk.kind == ChunkKind::Correction) place = &correction_chunk;
        if (chunk.kind == ChunkKind::Scaling) place = levels.data();
        if (chunk.kind == ChunkKind::Level) {
            if (chunk.level < 1 || chunk.level > layout.levels())
                return wrong("lists a level that does not exist");
            place = &levels[static_cast<std::size_t>(layout.levels() + 1 - chunk.level)];
        }
        if (place && place->has_value()) return wrong("lists a chunk twice");
        if (place) *place = k;
    }
    for (const auto& level : levels) {
        if (!level) return wrong("lacks a level");
        level_chunks.push_back(*level);
    }
    if (header.has_mask != mask_chunk.has_value())
        return wrong("does not agree with the header about a mask");
    return {};
}

Status RasterFile::State::read_side_data() {
    while (complete_levels <= layout.levels() &&
           container->complete(level_chunks[static_cast<std::size_t>(complete_levels)]))
        ++complete_levels;
    const auto cut = [&](std::optional<std::size_t> chunk) {
        return chunk && !container->complete(*chunk);
    };
    if (complete_levels == 0 || cut(mask_chunk) || cut(edits_chunk))
        return Error{ErrorCode::BadFile,
                     "not even the coarsest level is inside the bytes given; give more of the file",
                     ""};
    if (mask_chunk) {
        RELIEF_TRY(const auto data, container->chunk(*mask_chunk));
        mask = Grid<std::uint8_t>(layout.rows, layout.cols);
        RELIEF_CHECK(decode_mask(data, mask.view()));
    }
    if (edits_chunk) {
        RELIEF_TRY(const auto data, container->chunk(*edits_chunk));
        RELIEF_TRY(moves, read_moves(data, layout));
    }
    return {};
}

Result<Quantised> RasterFile::State::read_bands(int level) const {
    Quantised quantised;
    const int wanted = std::min(layout.levels() - level + 1, complete_levels);
    for (int number = 0; number < wanted; ++number) {
        RELIEF_TRY(const auto data,
                   container->chunk(level_chunks[static_cast<std::size_t>(number)]));
        RELIEF_CHECK(read_level(data, number, layout, quantised));
    }
    return quantised;
}

Result<LevelCoefficients<double>> RasterFile::State::base_coefficients(int level) const {
    RELIEF_TRY(Quantised quantised, read_bands(level));
    // Bands that were not read stay empty until zeros are needed for them.
    Pyramid<double> pyramid;
    pyramid.layout = layout;
    pyramid.bands.resize(layout.bands.size());
    for (std::size_t k = 0; k < layout.bands.size(); ++k) {
        const multires::BandLayout& band = layout.bands[k];
        if (k > 0 && band.level <= level) continue;
        const bool read = k < quantised.values.size() && !quantised.values[k].empty();
        const double step = read ? static_cast<double>(quantised.steps[k]) : 0;
        for (std::size_t c = 0; c < static_cast<std::size_t>(layout.components); ++c) {
            Grid<double> plane(band.box.rows, band.box.cols);
            for (std::int64_t r = 0; r < band.box.rows; ++r)
                for (std::int64_t j = 0; j < band.box.cols; ++j)
                    plane(r, j) = read ? quantised.values[k][c](r, j) * step : 0.0;
            pyramid.bands[k].push_back(std::move(plane));
        }
        if (read) quantised.values[k].clear();
    }
    return multires::coefficients(pyramid, level);
}

Result<Planes<double>> RasterFile::State::corrected_samples(int level) const {
    RELIEF_TRY(const LevelCoefficients<double> level_coefficients, base_coefficients(level));
    Planes<double> samples = multires::samples_of(layout, level_coefficients, level);
    if (level != 0 || !correction_chunk || !container->complete(*correction_chunk)) return samples;
    RELIEF_TRY(const auto data, container->chunk(*correction_chunk));
    RELIEF_TRY(const Corrections corrections,
               read_corrections(data, layout.rows, layout.cols, layout.components));
    apply_corrections(corrections, header.description.type, header.description.nodata, samples);
    if (all_finite(samples)) return samples;
    return Error{ErrorCode::BadFile,
                 "the corrections give samples that are not numbers; the file is damaged",
                 "correction chunk"};
}

RasterFile::RasterFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
RasterFile::RasterFile(RasterFile&&) noexcept = default;
RasterFile& RasterFile::operator=(RasterFile&&) noexcept = default;
RasterFile::~RasterFile() = default;

Result<RasterFile> RasterFile::open_prefix(std::vector<std::uint8_t> bytes,
                                           std::uint64_t file_size) {
    auto state = std::make_unique<State>();
    state->bytes = std::move(bytes);
    RELIEF_TRY(state->container, ContainerReader::open(state->bytes, file_size));
    RELIEF_CHECK(state->read_structure(file_size));
    RELIEF_CHECK(state->read_side_data());
    return RasterFile(std::move(state));
}

Result<RasterFile> RasterFile::open(std::vector<std::uint8_t> bytes) {
    const std::uint64_t size = bytes.size();
    RELIEF_TRY(RasterFile file, open_prefix(std::move(bytes), size));
    if (size == file.size()) return file;
    return Error{ErrorCode::BadFile,
                 "is cut off: " + std::to_string(size) + " of " + std::to_string(file.size()) +
                     " bytes are there; 'decode --bytes " + std::to_string(size) +
                     "' reads what is left",
                 ""};
}

const Raster& RasterFile::description() const {
    return state_->header.description;
}
const PyramidLayout& RasterFile::layout() const {
    return state_->layout;
}
const std::vector<Move>& RasterFile::moves() const {
    return state_->moves;
}
const Grid<std::uint8_t>& RasterFile::mask() const {
    return state_->mask;
}
Goal RasterFile::goal() const {
    return state_->header.goal;
}
double RasterFile::max_error() const {
    return state_->header.max_error;
}
double RasterFile::rms_error() const {
    return state_->header.rms_error;
}

int RasterFile::version() const {
    return kContainerVersion;
}
std::uint64_t RasterFile::size() const {
    return state_->container->complete_size();
}
bool RasterFile::checksums_ok() const {
    return state_->container->complete_chunks() == state_->container->chunks().size() &&
           state_->container->checksums_ok();
}

std::vector<BandInfo> RasterFile::bands() const {
    std::vector<BandInfo> bands;
    for (const multires::BandLayout& band : layout().bands) bands.push_back({band, 0});
    for (int number = 0; number < state_->complete_levels; ++number) {
        const auto data =
            state_->container->chunk(state_->level_chunks[static_cast<std::size_t>(number)]);
        if (!data.ok()) continue;
        ByteReader in(*data);
        for (BandInfo& band : bands)
            if (chunk_of(layout(), band.layout) == number)
                band.step = static_cast<double>(in.f32());
    }
    return bands;
}

std::vector<ChunkSummary> RasterFile::chunks() const {
    std::vector<ChunkSummary> chunks;
    for (const ChunkInfo& chunk : state_->container->chunks())
        chunks.push_back({std::string(chunk_kind_name(chunk.kind)), static_cast<int>(chunk.level),
                          chunk.length, chunk.bound, chunk.rms});
    return chunks;
}

int RasterFile::finest_level() const {
    return layout().levels() + 1 - state_->complete_levels;
}

std::optional<double> RasterFile::bound(int level) const {
    if (edited()) return {};
    const auto& container = *state_->container;
    if (level == 0 && state_->correction_chunk && container.complete(*state_->correction_chunk))
        return goal().kind == Goal::Kind::MaxError ? goal().value : max_error();
    const int used = std::min(layout().levels() - level, state_->complete_levels - 1);
    return container.chunks()[state_->level_chunks[static_cast<std::size_t>(used)]].bound;
}

std::uint64_t RasterFile::bytes_for(int level) const {
    const auto& chunks = state_->container->chunks();
    std::uint64_t end = 0;
    const int wanted = std::min(layout().levels() - level + 1, state_->complete_levels);
    for (int number = 0; number < wanted; ++number) {
        const ChunkInfo& chunk = chunks[state_->level_chunks[static_cast<std::size_t>(number)]];
        end = std::max(end, chunk.offset + chunk.length);
    }
    if (level != 0) return end;
    for (std::size_t k = 0; k < chunks.size(); ++k)
        if (state_->container->complete(k))
            end = std::max(end, chunks[k].offset + chunks[k].length);
    return end;
}

Result<LevelCoefficients<double>> RasterFile::coefficients(int level) const {
    if (level < 0 || level > layout().levels())
        return Error{ErrorCode::InvalidArgument,
                     "there is no level " + std::to_string(level) +
                         "; the file has levels 0 (finest) to " + std::to_string(layout().levels()),
                     ""};
    RELIEF_TRY(LevelCoefficients<double> result, state_->base_coefficients(level));
    if (edited())
        add(result.planes, multires::displacement<double>(layout(), moves(), level).planes);
    return result;
}

Result<Planes<double>> RasterFile::control_net() const {
    const bool corrected =
        state_->correction_chunk && state_->container->complete(*state_->correction_chunk);
    if (!corrected) {
        RELIEF_TRY(LevelCoefficients<double> finest, coefficients(0));
        return std::move(finest.planes);
    }
    RELIEF_TRY(Planes<double> net, state_->corrected_samples(0));
    const multires::SchemeSpec& spec = layout().spec;
    if (!multires::samples_are_coefficients(spec))
        for (Grid<double>& plane : net) {
            Grid<double> solved(plane.rows(), plane.cols());
            RELIEF_CHECK(
                spline::interpolate_lattice<double>(spec.order, plane.view(), solved.view()));
            plane = std::move(solved);
        }
    if (edited()) add(net, multires::displacement<double>(layout(), moves(), 0).planes);
    return net;
}

Result<Raster> RasterFile::decode(int level) const {
    if (level < 0 || level > layout().levels()) return coefficients(level).error();
    RELIEF_TRY(Planes<double> samples, state_->corrected_samples(level));
    const Raster& about = description();
    if (edited()) {
        const auto moved = multires::displacement<double>(layout(), moves(), level);
        add(samples, multires::samples_of(layout(), moved, level));
    }
    Raster result;
    result.rows = samples[0].rows();
    result.cols = samples[0].cols();
    result.type = about.type;
    result.nodata = about.nodata;
    result.geo = georeference_of(about.geo, level);
    result.unit = about.unit;
    result.scale = about.scale;
    result.offset = about.offset;
    result.band_names = about.band_names;
    result.metadata = about.metadata;
    const std::int64_t step = std::int64_t{1} << level;
    if (!state_->mask.empty()) {
        result.mask = Grid<std::uint8_t>(result.rows, result.cols);
        for (std::int64_t r = 0; r < result.rows; ++r)
            for (std::int64_t c = 0; c < result.cols; ++c)
                result.mask(r, c) = state_->mask(r * step, c * step);
    }
    for (Grid<double>& plane : samples)
        parallel_for(0, plane.rows(), 32, [&](std::int64_t first, std::int64_t last) {
            for (std::int64_t r = first; r < last; ++r)
                for (std::int64_t c = 0; c < plane.cols(); ++c)
                    plane(r, c) = result.valid(r, c)
                                      ? stored_value(plane(r, c), about.type, about.nodata)
                                      : std::numeric_limits<double>::quiet_NaN();
        });
    result.planes = std::move(samples);
    return result;
}

Result<std::vector<std::uint8_t>> add_moves(std::span<const std::uint8_t> file,
                                            const std::vector<Move>& moves) {
    RELIEF_TRY(const RasterFile opened,
               RasterFile::open(std::vector<std::uint8_t>(file.begin(), file.end())));
    std::vector<Move> all = opened.moves();
    for (const Move& move : moves) {
        RELIEF_CHECK(multires::check_move(opened.layout(), move));
        if (!is_displacement(move))
            return Error{ErrorCode::InvalidArgument,
                         "a displacement is not a number of at most 1e300", ""};
        all.push_back(move);
    }
    RELIEF_TRY(const ContainerReader reader, ContainerReader::open(file, file.size()));
    ContainerWriter writer(reader.header());
    for (std::size_t k = 0; k < reader.chunks().size(); ++k) {
        const ChunkInfo& chunk = reader.chunks()[k];
        if (chunk.kind == ChunkKind::Edits) continue;
        if (chunk.kind == ChunkKind::Scaling)
            RELIEF_CHECK(writer.add({.kind = ChunkKind::Edits}, write_moves(all)));
        RELIEF_TRY(const auto data, reader.chunk(k));
        RELIEF_CHECK(writer.add(chunk, data));
    }
    return writer.finish();
}

}  // namespace relief::codec
