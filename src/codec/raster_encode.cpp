#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "codec/goal_search.h"
#include "codec/lattice_encode.h"
#include "codec/lattice_margin.h"
#include "codec/pyramid_encode.h"
#include "codec/pyramid_tiles.h"
#include "codec/raster_encode.h"
#include "codec/surface_error.h"
#include "relief/codec/raster_codec.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

using Kind = Goal::Kind;
using multires::SchemeId;
using multires::SchemeSpec;

/// Where the open loop may keep a bound with fewer bytes, and has the memory: bits a sample, and
/// samples.
constexpr double kOpenLoopBits = 1;
constexpr std::int64_t kOpenLoopSamples = std::int64_t{1} << 23;
/// Larger rasters are coded in tiles by the open loop, where it can.
constexpr std::int64_t kWholeSamples = std::int64_t{1} << 20;

/// Bounds are kept best by quantising inside the prediction, squared errors by smooth bases.
SchemeSpec best_scheme(const Goal& goal) {
    return {.id = is_bound(goal) ? SchemeId::Fvs : SchemeId::Cubic};
}

/// The closed loop to a sink.
class LatticeWriter {
  public:
    LatticeWriter(const RasterSource& raster, LatticeMargin margin, const EncodeOptions& options,
                  ByteSink& sink, Spool& spool)
        : raster_(raster),
          margin_(margin),
          source_(raster, margin),
          options_(options),
          sink_(sink),
          spool_(spool) {}

    /// False: the samples do not fit its integers.
    Result<bool> encode() {
        const double bound = bound_of(options_.goal);
        RELIEF_TRY(const Survey seen, survey(source_, options_.progress));
        LatticeCoding coding;
        coding.profile = options_.profile;
        coding.margin = margin_;
        RELIEF_TRY(const bool fits, choose_domains(source_, seen, bound, coding));
        if (!fits) return false;
        RELIEF_TRY(encoding_,
                   encode_lattice(source_, seen, std::move(coding),
                                  {options_.profile, bound, true, options_.progress}, spool_));
        RELIEF_CHECK(make_head());
        report_.bound = options_.goal.kind == Kind::MaxError ? bound : encoding_.max_error;
        return true;
    }

    /// Of the file; known once it is encoded.
    [[nodiscard]] const EncodeReport& report() const { return report_; }

    Status write() { return file_->copy_to(sink_); }

  private:
    Status make_head() {
        const LatticeEncoding& encoding = encoding_;
        const Raster& about = raster_.description();
        RasterHeader header =
            lattice_header(raster_, options_.goal, encoding.coding, encoding.has_holes);
        set_errors(header, encoding);
        const SurfaceError error{encoding.max_error, encoding.square_error};
        const std::int64_t values = encoding.samples * header.components;

        std::vector<SpooledChunk> chunks(1);  // no edits
        chunks.insert(chunks.end(), encoding.chunks.begin(), encoding.chunks.end());
        RELIEF_TRY(file_, SpooledFile::create(write_header(header), std::move(chunks), spool_));

        report_ = size_report(about, file_->size());
        report_.spec = header.spec;
        report_.closed_loop = true;
        report_.profile = options_.profile;
        report_.lattice = encoding.coding.domains[0].lattice ? encoding.coding.domains[0].unit : 0;
        report_.coefficients = report_.samples;
        report_.kept = encoding.nonzero;
        report_.corrected = encoding.repairs;
        set_errors(report_, error, values, encoding.coarse_energy);
        return {};
    }

    const RasterSource& raster_;
    LatticeMargin margin_;
    RasterWithMargin source_;
    const EncodeOptions& options_;
    ByteSink& sink_;
    Spool& spool_;
    LatticeEncoding encoding_;
    std::shared_ptr<const SpooledFile> file_;
    EncodeReport report_;
};

Result<EncodedRaster> encode_open(const RasterSource& source, const SchemeSpec& spec,
                                  const EncodeOptions& options) {
    const Raster& about = source.description();
    RELIEF_TRY(Raster raster, source.read({0, 0, about.rows, about.cols}));
    Raster whole = description_of(about);
    whole.planes = std::move(raster.planes);
    whole.mask = std::move(raster.mask);
    return encode_pyramid(whole, spec, options);
}

/// The open loop where it may be smaller than a closed-loop file: at loose bounds; none if that
/// file is exact or is to be made fast, the raster too large for the memory of the open loop, or
/// its file larger.
Result<std::optional<EncodedRaster>> encode_looser(const RasterSource& source,
                                                   const EncodeOptions& options,
                                                   const EncodeReport& closed) {
    if (options.goal.kind != Kind::MaxError || options.profile == Profile::Fast ||
        closed.max_error == 0 || closed.bits_per_sample > kOpenLoopBits ||
        closed.samples > kOpenLoopSamples)
        return std::optional<EncodedRaster>();
    EncodeOptions quiet = options;
    if (options.progress) quiet.progress = [&](double) { return options.progress(1); };
    auto open = encode_open(source, {.id = SchemeId::Cubic}, quiet);
    if (!open.ok() && open.error().code == ErrorCode::Cancelled) return open.error();
    if (!open.ok() || open->bytes.size() >= closed.bytes) return std::optional<EncodedRaster>();
    return std::optional<EncodedRaster>(*std::move(open));
}

}  // namespace

Status check_raster(const RasterSource& source, const Goal& goal) {
    RELIEF_CHECK(check_goal(goal));
    const Raster& about = source.description();
    if (about.rows < 1 || about.cols < 1 || source.components() < 1)
        return Error{ErrorCode::BadInput, "the raster is empty; it needs at least one sample", ""};
    if (about.rows > INT32_MAX || about.cols > INT32_MAX || source.components() > 4)
        return Error{ErrorCode::BadInput,
                     "the raster has more than 2^31 - 1 samples a side or more than 4 components; "
                     "encode it in parts",
                     ""};
    return {};
}

bool is_bound(const Goal& goal) {
    return goal.kind == Kind::MaxError || goal.kind == Kind::Lossless ||
           (goal.kind == Kind::RmsError && goal.value == 0);
}

RasterHeader lattice_header(const RasterSource& raster, const Goal& goal, LatticeCoding coding,
                            bool has_holes) {
    RasterHeader header;
    header.description = description_of(raster.description());
    header.components = raster.components();
    header.has_mask = has_holes;
    header.goal = goal;
    header.lattice = std::move(coding);
    header.spec = {.id = SchemeId::Fvs,
                   .levels = TileTree(header.lattice_rows(), header.lattice_cols()).levels()};
    return header;
}

void set_errors(RasterHeader& header, const LatticeEncoding& encoding) {
    const SurfaceError error{encoding.max_error, encoding.square_error};
    header.max_error = encoding.max_error;
    header.rms_error = error.rms(encoding.samples * header.components);
}

Result<EncodeReport> encode_raster(const RasterSource& source, const EncodeOptions& options,
                                   ByteSink& sink, Spool& spool) {
    RELIEF_CHECK(check_raster(source, options.goal));
    SchemeSpec spec = options.spec.value_or(best_scheme(options.goal));
    if (spec.id == SchemeId::Fvs && is_bound(options.goal)) {
        RELIEF_TRY(const LatticeMargin margin, choose_margin(source));
        LatticeWriter writer(source, margin, options, sink, spool);
        RELIEF_TRY(const bool fits, writer.encode());
        if (fits) {
            std::optional<EncodedRaster> open;
            if (!options.spec) {
                RELIEF_TRY(open, encode_looser(source, options, writer.report()));
            }
            RELIEF_CHECK(open ? sink.write(open->bytes) : writer.write());
            return open ? open->report : writer.report();
        }
        spec = {.id = SchemeId::Cubic};
    }
    const Raster& about = source.description();
    if (about.rows * about.cols * source.components() > kWholeSamples &&
        fits_tiles(about, source.components(), spec, options.goal)) {
        RELIEF_TRY(const std::optional<EncodeReport> report,
                   encode_tiles(source, spec, options, sink, spool));
        if (report) return *report;
    }
    RELIEF_TRY(const EncodedRaster encoded, encode_open(source, spec, options));
    RELIEF_CHECK(sink.write(encoded.bytes));
    return encoded.report;
}

Result<EncodedRaster> encode_raster(const Raster& raster, const EncodeOptions& options) {
    MemorySink sink;
    MemorySpool spool;
    EncodedRaster encoded;
    RELIEF_TRY(encoded.report, encode_raster(MemoryRaster(raster), options, sink, spool));
    encoded.bytes = sink.take();
    return encoded;
}

Result<double> detail_energy(const Raster& raster, const SchemeSpec& spec) {
    if (spec.id != SchemeId::Fvs) return pyramid_energy(raster, spec);
    const MemoryRaster source(raster);
    RELIEF_TRY(const Survey seen, survey(source, {}));
    return coarse_energy(view_of(raster), 0, seen, source.description());
}

}  // namespace relief::codec
