#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "codec/moves.h"
#include "codec/raster_body.h"
#include "codec/raster_header.h"
#include "relief/codec/container.h"
#include "relief/codec/raster_codec.h"
#include "relief/core/parallel.h"

namespace relief::codec {

using multires::LevelCoefficients;
using multires::Move;
using multires::Planes;
using multires::PyramidLayout;

namespace {

/// Samples that the header of an open-loop file may claim: any raster of some size, or so many a
/// byte that only one without content has more.
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

/// Adds coefficients of the same level on a box that covers that of `to`.
void add(LevelCoefficients<double>& to, const LevelCoefficients<double>& from) {
    const std::int64_t row = to.box.row0 - from.box.row0;
    const std::int64_t col = to.box.col0 - from.box.col0;
    for (std::size_t p = 0; p < to.planes.size(); ++p)
        for (std::int64_t r = 0; r < to.box.rows; ++r)
            for (std::int64_t c = 0; c < to.box.cols; ++c)
                to.planes[p](r, c) += from.planes[p](row + r, col + c);
}

Planes<double> without(LatticeMargin margin, Planes<double> planes) {
    if (margin == LatticeMargin()) return planes;
    for (Grid<double>& plane : planes) {
        Grid<double> rest(plane.rows() - margin.rows, plane.cols() - margin.cols);
        for (std::int64_t r = 0; r < rest.rows(); ++r)
            std::copy_n(plane.row(r + margin.rows) + margin.cols, rest.cols(), rest.row(r));
        plane = std::move(rest);
    }
    return planes;
}

/// The control net of closed-loop files, and the scheme whose functions moves add.
multires::SchemeSpec editing_spec(const RasterHeader& header) {
    if (!header.lattice) return header.spec;
    return {.id = multires::SchemeId::Cubic, .levels = header.spec.levels};
}

}  // namespace

struct RasterFile::State {
    std::optional<ContainerReader> container;
    RasterHeader header;
    PyramidLayout layout;
    std::vector<Move> moves;
    std::unique_ptr<RasterBody> body;

    Status open(std::shared_ptr<const ByteSource> source, std::uint64_t visible);
    /// The moved surface's samples of a window.
    void displace(int level, const LatticeBox& window, Planes<double>& planes) const;
};

Status RasterFile::State::open(std::shared_ptr<const ByteSource> source, std::uint64_t visible) {
    const std::uint64_t file_size = source->size();
    RELIEF_TRY(container, ContainerReader::open(std::move(source), visible));
    RELIEF_TRY(header, read_header(container->header()));
    if (!header.lattice) RELIEF_CHECK(check_size(header.description, header.components, file_size));
    auto bands = multires::layout(editing_spec(header), header.lattice_rows(),
                                  header.lattice_cols(), header.components);
    if (!bands.ok())
        return Error{ErrorCode::BadFile,
                     "describes an impossible pyramid: " + bands.error().message, "header"};
    layout = *std::move(bands);
    if (container->chunks().empty())
        return Error{ErrorCode::BadFile, "has no chunks; the file is damaged", "directory"};
    if (container->chunks()[kEditsChunk].length > 0) {
        RELIEF_TRY(const Bytes data, container->chunk(kEditsChunk));
        RELIEF_TRY(moves, read_moves(data, layout));
    }
    RELIEF_TRY(body, header.lattice ? open_lattice_body(*container, header, layout)
                                    : open_pyramid_body(*container, header, layout));
    return {};
}

void RasterFile::State::displace(int level, const LatticeBox& window,
                                 Planes<double>& planes) const {
    const Planes<double> moved =
        multires::samples_of(layout, multires::displacement<double>(layout, moves, level), level);
    for (std::size_t p = 0; p < planes.size(); ++p)
        for (std::int64_t r = 0; r < window.rows; ++r)
            for (std::int64_t c = 0; c < window.cols; ++c)
                planes[p](r, c) += moved[p](window.row0 + r, window.col0 + c);
}

RasterFile::RasterFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
RasterFile::RasterFile(RasterFile&&) noexcept = default;
RasterFile& RasterFile::operator=(RasterFile&&) noexcept = default;
RasterFile::~RasterFile() = default;

Result<RasterFile> RasterFile::open(std::shared_ptr<const ByteSource> source,
                                    std::uint64_t visible) {
    auto state = std::make_unique<State>();
    const std::uint64_t size = source->size();
    RELIEF_CHECK(state->open(std::move(source), visible));
    const std::uint64_t whole = state->container->complete_size();
    const bool all = visible == std::numeric_limits<std::uint64_t>::max();
    if (all && size < whole)
        return Error{ErrorCode::BadFile,
                     "is cut off: " + std::to_string(size) + " of " + std::to_string(whole) +
                         " bytes are there; 'decode --bytes " + std::to_string(size) +
                         "' reads what is left",
                     ""};
    return RasterFile(std::move(state));
}

Result<RasterFile> RasterFile::open(Bytes bytes) {
    return open(std::make_shared<MemorySource>(std::move(bytes)));
}

const Raster& RasterFile::description() const {
    return state_->header.description;
}
const multires::SchemeSpec& RasterFile::spec() const {
    return state_->header.spec;
}
const PyramidLayout& RasterFile::layout() const {
    return state_->layout;
}
LatticeMargin RasterFile::margin() const {
    return state_->header.margin();
}
std::optional<std::pair<double, double>> RasterFile::original_range(int component) const {
    if (!closed_loop() || edited()) return {};
    const IntegerDomain& domain =
        state_->header.lattice->domains[static_cast<std::size_t>(component)];
    return std::pair{domain.value(0), domain.value(domain.highest)};
}
bool RasterFile::has_holes() const {
    return state_->header.has_mask;
}
bool RasterFile::closed_loop() const {
    return state_->header.lattice.has_value();
}
std::string RasterFile::profile() const {
    return closed_loop() ? std::string(profile_name(state_->header.lattice->profile)) : "";
}
const std::vector<Move>& RasterFile::moves() const {
    return state_->moves;
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
bool RasterFile::complete() const {
    return state_->container->complete_chunks() == state_->container->chunks().size();
}
bool RasterFile::checksums_ok() const {
    return complete() && state_->container->checksums_ok();
}

std::vector<BandInfo> RasterFile::bands() const {
    const std::vector<double> steps = state_->body->band_steps();
    std::vector<BandInfo> bands;
    for (std::size_t k = 0; k < layout().bands.size(); ++k)
        bands.push_back({layout().bands[k], steps[k]});
    return bands;
}

std::vector<ChunkSummary> RasterFile::chunks() const {
    std::vector<ChunkSummary> all;
    if (edited()) {
        ChunkSummary edits;
        edits.kind = "edits";
        edits.bytes = state_->container->chunks()[kEditsChunk].length;
        edits.max_error = std::numeric_limits<double>::infinity();
        all.push_back(edits);
    }
    for (ChunkSummary& chunk : state_->body->chunks()) all.push_back(std::move(chunk));
    return all;
}

int RasterFile::finest_level() const {
    return state_->body->finest_level();
}

namespace {

std::optional<double> if_known(double bound, bool edited) {
    if (edited || std::isinf(bound)) return {};
    return bound;
}

}  // namespace

std::optional<double> RasterFile::bound(int level) const {
    return if_known(state_->body->bound(level), edited());
}

std::optional<double> RasterFile::surface_bound(int level) const {
    return if_known(state_->body->surface_bound(level), edited());
}

std::uint64_t RasterFile::bytes_for(int level) const {
    return state_->body->bytes_for(level);
}

std::uint64_t RasterFile::bytes_read() const {
    return state_->container->bytes_read();
}

LatticeBox RasterFile::box(int level) const {
    if (level == 0) return {0, 0, description().rows, description().cols};
    const std::int64_t step = std::int64_t{1} << level;
    return {0, 0, (layout().rows + step - 1) / step, (layout().cols + step - 1) / step};
}

Sampling RasterFile::samples_of_level(int level, const LatticeBox& window) const {
    const double step = std::ldexp(1.0, level);
    const LatticeMargin before = level == 0 ? LatticeMargin() : margin();
    const auto place = [step](std::int64_t first, std::int64_t margin) {
        return static_cast<double>(first) * step - static_cast<double>(margin);
    };
    return {{place(window.row0, before.rows), step, window.rows},
            {place(window.col0, before.cols), step, window.cols}};
}

bool RasterFile::decodes_parts() const {
    return !edited() && state_->body->decodes_parts();
}

namespace {

Status check_level(const PyramidLayout& layout, int level) {
    if (level >= 0 && level <= layout.levels()) return {};
    return Error{ErrorCode::InvalidArgument,
                 "there is no level " + std::to_string(level) +
                     "; the file has levels 0 (finest) to " + std::to_string(layout.levels()),
                 ""};
}

}  // namespace

Result<LevelCoefficients<double>> RasterFile::coefficients(int level) const {
    RELIEF_CHECK(check_level(layout(), level));
    return coefficients(level, multires::scaling_box(layout(), level));
}

Result<LevelCoefficients<double>> RasterFile::coefficients(int level,
                                                           const LatticeBox& part) const {
    RELIEF_TRY(ControlPart control, control_part(level, part));
    return std::move(control.net);
}

Result<ControlPart> RasterFile::control_part(int level, const LatticeBox& part) const {
    RELIEF_CHECK(check_level(layout(), level));
    const LatticeBox all = multires::scaling_box(layout(), level);
    if (part.rows < 1 || part.cols < 1 || !all.contains(part.row0, part.col0) ||
        !all.contains(part.row0 + part.rows - 1, part.col0 + part.cols - 1))
        return Error{ErrorCode::InvalidArgument,
                     "the part is not inside the control net of level " + std::to_string(level),
                     ""};
    RELIEF_TRY(ControlPart result, state_->body->coefficients(level, part));
    if (edited()) {
        const auto moved = multires::displacement<double>(layout(), moves(), level);
        add(result.net, moved);
    }
    return result;
}

Result<Planes<double>> RasterFile::control_net() const {
    RELIEF_TRY(Planes<double> net, state_->body->control_net());
    LevelCoefficients<double> whole{multires::scaling_box(layout(), 0), std::move(net)};
    if (edited()) add(whole, multires::displacement<double>(layout(), moves(), 0));
    return without(margin(), std::move(whole.planes));
}

Status check_damage(const std::vector<LatticeBox>& damaged) {
    if (damaged.empty()) return {};
    const LatticeBox& first = damaged.front();
    return Error{ErrorCode::BadFile,
                 "chunks of columns " + std::to_string(first.col0) + " to " +
                     std::to_string(first.col0 + first.cols - 1) + ", rows " +
                     std::to_string(first.row0) + " to " +
                     std::to_string(first.row0 + first.rows - 1) +
                     (damaged.size() > 1 ? " and of more tiles" : "") +
                     " are damaged; 'decode --allow-damage' fills them in from coarser ones",
                 ""};
}

Status RasterFile::check_window(int level, const LatticeBox& window) const {
    RELIEF_CHECK(check_level(layout(), level));
    const LatticeBox all = box(level);
    if (window.rows >= 1 && window.cols >= 1 && window.row0 >= 0 && window.col0 >= 0 &&
        window.row0 <= all.rows - window.rows && window.col0 <= all.cols - window.cols)
        return {};
    return Error{ErrorCode::InvalidArgument,
                 "the window " + std::to_string(window.col0) + "," + std::to_string(window.row0) +
                     "," + std::to_string(window.cols) + "," + std::to_string(window.rows) +
                     " is not inside the " + std::to_string(all.cols) + " x " +
                     std::to_string(all.rows) + " raster",
                 ""};
}

Result<DecodedRaster> RasterFile::decode_window(int level, const LatticeBox& window) const {
    RELIEF_CHECK(check_window(level, window));
    LatticeBox part = window;
    if (level == 0) {
        part.row0 += margin().rows;
        part.col0 += margin().cols;
    }
    RELIEF_TRY(BodySamples samples, state_->body->samples(level, part));
    if (edited()) {
        state_->displace(level, part, samples.planes);
        samples.stored = false;
    }
    DecodedRaster decoded;
    Raster& raster = decoded.raster;
    raster = description_of(description());
    raster.rows = window.rows;
    raster.cols = window.cols;
    raster.geo = georeference_of(raster.geo, samples_of_level(level, window));
    raster.mask = std::move(samples.mask);
    for (Grid<double>& plane : samples.planes) {
        if (samples.stored) continue;
        parallel_for(0, plane.rows(), 32, [&](std::int64_t first, std::int64_t last) {
            for (std::int64_t r = first; r < last; ++r) {
                stored_row(plane.row(r), plane.cols(), raster.type, raster.nodata, plane.row(r));
                for (std::int64_t c = 0; c < plane.cols(); ++c)
                    if (!raster.valid(r, c)) plane(r, c) = std::numeric_limits<double>::quiet_NaN();
            }
        });
    }
    raster.planes = std::move(samples.planes);
    decoded.bound = if_known(samples.bound, edited());
    decoded.damaged = std::move(samples.damaged);
    return decoded;
}

Result<Raster> RasterFile::decode(int level) const {
    RELIEF_CHECK(check_level(layout(), level));
    RELIEF_TRY(DecodedRaster decoded, decode_window(level, box(level)));
    if (decoded.damaged.empty()) return std::move(decoded.raster);
    const LatticeBox& first = decoded.damaged.front();
    return Error{ErrorCode::BadFile,
                 "chunks of " + std::to_string(decoded.damaged.size()) +
                     " tiles are damaged; 'decode --allow-damage' fills them in from coarser ones",
                 "columns " + std::to_string(first.col0) + " to " +
                     std::to_string(first.col0 + first.cols - 1) + ", rows " +
                     std::to_string(first.row0) + " to " +
                     std::to_string(first.row0 + first.rows - 1)};
}

namespace {

/// The file with other moves.
Status write_with(const std::shared_ptr<const ByteSource>& source, const std::vector<Move>& moves,
                  ByteSink& sink) {
    RELIEF_TRY(const ContainerReader reader, ContainerReader::open(source));
    return write_with_edits(reader, moves.empty() ? Bytes() : write_moves(moves), sink);
}

}  // namespace

void note_origin(const RasterFile& file, std::optional<double> bound, Raster& raster) {
    std::erase_if(raster.metadata,
                  [](const auto& item) { return item.first.starts_with("RELIEF_"); });
    const multires::SchemeSpec& spec = file.spec();
    raster.metadata.emplace_back("RELIEF_SCHEME", std::string(multires::scheme_name(spec.id)) +
                                                      " order " + std::to_string(spec.order));
    raster.metadata.emplace_back("RELIEF_LEVELS", std::to_string(spec.levels));
    if (!bound) return;
    std::array<char, 32> text{};
    char* const end = std::to_chars(text.data(), text.data() + text.size(), *bound).ptr;
    raster.metadata.emplace_back("RELIEF_MAX_ERROR", std::string(text.data(), end));
}

Status add_moves(const std::shared_ptr<const ByteSource>& source, const std::vector<Move>& moves,
                 ByteSink& sink) {
    RELIEF_TRY(const RasterFile opened, RasterFile::open(source));
    std::vector<Move> all = opened.moves();
    for (const Move& move : moves) {
        RELIEF_CHECK(multires::check_move(opened.layout(), move));
        if (!is_displacement(move))
            return Error{ErrorCode::InvalidArgument,
                         "a displacement is not a number of at most 1e300", ""};
        all.push_back(move);
    }
    return write_with(source, all, sink);
}

Result<Bytes> without_moves(const std::shared_ptr<const ByteSource>& source) {
    RELIEF_TRY(const RasterFile opened, RasterFile::open(source));
    MemorySink sink;
    RELIEF_CHECK(write_with(source, {}, sink));
    return sink.take();
}

Result<Bytes> add_moves(Bytes file, const std::vector<Move>& moves) {
    MemorySink sink;
    RELIEF_CHECK(add_moves(std::make_shared<MemorySource>(std::move(file)), moves, sink));
    return sink.take();
}

}  // namespace relief::codec
