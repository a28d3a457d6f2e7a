#include <fmt/format.h>

#include <cmath>

#include "command.h"
#include "mesh_verbs.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/codec/raster_sampler.h"
#include "relief/io/raster.h"

namespace relief::cli {

namespace {

struct Decode {
    std::string in;
    std::string out;
    int level = 0;
    std::optional<std::int64_t> bytes;
    std::vector<std::int64_t> window;
    double scale = 1;
    std::optional<double> cell;
    bool allow_damage = false;
};

/// Rows that are decoded at a time when the whole would be large.
constexpr std::int64_t kStrip = 512;
constexpr std::int64_t kLarge = std::int64_t{1} << 24;

Result<LatticeBox> window_of(const Decode& options, const LatticeBox& all) {
    if (options.window.empty()) return all;
    const LatticeBox box{options.window[1], options.window[0], options.window[3],
                         options.window[2]};
    if (box.rows >= 1 && box.cols >= 1 && box.row0 >= 0 && box.col0 >= 0 &&
        box.row0 <= all.rows - box.rows && box.col0 <= all.cols - box.cols)
        return box;
    return Error{ErrorCode::InvalidArgument,
                 fmt::format("the window {},{},{},{} is not inside the {} x {} raster", box.col0,
                             box.row0, box.cols, box.rows, all.cols, all.rows),
                 ""};
}

/// A side of n samples at `scale` times as many: cells that cover the same ground.
SampleAxis rescaled(std::int64_t n, double scale) {
    const double count = std::max(1.0, std::ceil(static_cast<double>(n) * scale - 1e-9));
    return SampleAxis{0, 1, n}.cut(0, count / scale, static_cast<std::int64_t>(count));
}

/// Errors: InvalidArgument.
Result<Sampling> rescaled(const Raster& about, double scale) {
    if (static_cast<double>(std::max(about.rows, about.cols)) * scale > INT32_MAX)
        return Error{ErrorCode::InvalidArgument, "--scale makes the raster too large", ""};
    return Sampling{rescaled(about.rows, scale), rescaled(about.cols, scale)};
}

/// Samples of a window of what was asked for.
class Source {
  public:
    static Result<Source> create(const codec::RasterFile& file, const Decode& options) {
        Source source(file, options);
        source.box_ = file.box(std::min(options.level, file.layout().levels()));
        if (options.level > file.layout().levels()) return file.decode(options.level).error();
        if (options.scale != 1) {
            RELIEF_TRY(source.rescaled_, rescaled(file.description(), options.scale));
            source.box_ = {0, 0, source.rescaled_->rows.count, source.rescaled_->cols.count};
        }
        return source;
    }

    [[nodiscard]] const LatticeBox& box() const { return box_; }

    [[nodiscard]] Result<Raster> window(const LatticeBox& part) {
        if (rescaled_) return rescaled_window(part);
        RELIEF_TRY(codec::DecodedRaster decoded, file_.decode_window(options_.level, part));
        if (!options_.allow_damage) RELIEF_CHECK(codec::check_damage(decoded.damaged));
        damaged_.insert(damaged_.end(), decoded.damaged.begin(), decoded.damaged.end());
        bound_ = bound_ && decoded.bound ? std::optional(std::max(*bound_, *decoded.bound))
                                         : std::nullopt;
        return std::move(decoded.raster);
    }

    /// Of all windows so far.
    [[nodiscard]] std::optional<double> bound() const { return rescaled_ ? std::nullopt : bound_; }
    [[nodiscard]] const std::vector<LatticeBox>& damaged() const { return damaged_; }

  private:
    Source(const codec::RasterFile& file, const Decode& options)
        : file_(file), options_(options), sampler_(file) {}

    [[nodiscard]] Result<Raster> rescaled_window(const LatticeBox& part) {
        const auto cut = [](const SampleAxis& axis, std::int64_t first, std::int64_t count) {
            return axis.cut(static_cast<double>(first), static_cast<double>(count), count);
        };
        // Heights between those of samples are no integers.
        const SampleType type = file_.description().type;
        return sampler_.values({cut(rescaled_->rows, part.row0, part.rows),
                                cut(rescaled_->cols, part.col0, part.cols)},
                               is_integer(type) ? SampleType::Float32 : type);
    }

    const codec::RasterFile& file_;
    const Decode& options_;
    codec::RasterSampler sampler_;
    LatticeBox box_;
    std::optional<Sampling> rescaled_;
    std::optional<double> bound_ = 0;
    std::vector<LatticeBox> damaged_;
};

Status write_whole(Source& source, const LatticeBox& window, const codec::RasterFile& file,
                   const Decode& options, const Globals& globals) {
    auto decoded = source.window(window);
    if (!decoded.ok()) return located(decoded.error(), options.in);
    codec::note_origin(file, source.bound(), *decoded);
    return io::write_raster(options.out, *decoded, {.progress = progress_bar(globals, "writing")});
}

/// Rows of tiles after another, so that memory does not grow with their number.
Status write_strips(Source& source, const LatticeBox& window, const codec::RasterFile& file,
                    const Decode& options, const Globals& globals) {
    const Progress progress = progress_bar(globals, "decoding");
    std::optional<io::RasterWriter> writer;
    for (std::int64_t row = 0; row < window.rows;) {
        // Strips end where tiles do.
        const std::int64_t top = window.row0 + row;
        const std::int64_t rows = std::min(kStrip - top % kStrip, window.rows - row);
        auto strip = source.window({top, window.col0, rows, window.cols});
        if (!strip.ok()) return located(strip.error(), options.in);
        if (!writer) {
            Raster about = description_of(*strip);
            about.rows = window.rows;
            codec::note_origin(
                file, options.allow_damage ? std::nullopt : file.bound(options.level), about);
            RELIEF_TRY(auto made, io::RasterWriter::create(
                                      options.out, about, static_cast<int>(strip->planes.size()),
                                      file.has_holes() ? io::Holes::Possible : io::Holes::None));
            writer.emplace(std::move(made));
        }
        RELIEF_CHECK(writer->write(row, *strip));
        row += rows;
        if (progress && !progress(static_cast<double>(row) / static_cast<double>(window.rows)))
            return Error{ErrorCode::Cancelled, "decoding was cancelled", options.out};
    }
    return writer->commit();
}

Json damage_json(const std::vector<LatticeBox>& damaged) {
    Json list = Json::array();
    for (const LatticeBox& box : damaged)
        list.push_back(
            Json{{"col", box.col0}, {"row", box.row0}, {"width", box.cols}, {"height", box.rows}});
    return list;
}

/// Files of meshes have levels, but no windows and scales.
Result<Outcome> decode_any_mesh(const Decode& options) {
    if (!options.window.empty() || options.scale != 1)
        return Error{ErrorCode::InvalidArgument, "--window and --scale are for rasters",
                     options.in};
    if (holds_mesh(options.in))
        return decode_mesh(options.in, options.out, options.level, options.bytes);
    return decode_quads(options.in, options.out, options.level, options.bytes);
}

Result<Outcome> run(const Decode& options, const Globals& globals) {
    const Stopwatch watch;
    if (!(options.scale > 0 && std::isfinite(options.scale)))
        return Error{ErrorCode::InvalidArgument, "--scale must be a positive number", ""};
    if (options.scale != 1 && options.level != 0)
        return Error{ErrorCode::InvalidArgument, "--scale and --level exclude each other", ""};
    if (options.bytes && *options.bytes < 1)
        return Error{ErrorCode::InvalidArgument, "--bytes must be at least 1", ""};
    if (holds_ps(options.in))
        return decode_ps({options.in, options.out, options.level, options.bytes, options.cell,
                          options.scale, options.window},
                         globals);
    if (options.cell)
        return Error{ErrorCode::InvalidArgument,
                     "--cell is for splines on triangles; rasters have --scale", options.in};
    if (holds_quads(options.in) || holds_mesh(options.in)) return decode_any_mesh(options);
    RELIEF_TRY(const codec::RasterFile file, open_relief(options.in, options.bytes));
    auto source = Source::create(file, options);
    if (!source.ok()) return located(source.error(), options.in);
    const auto window = window_of(options, source->box());
    if (!window.ok()) return located(window.error(), options.in);
    const bool in_strips = file.closed_loop() && window->count() > kLarge;
    const Status written = in_strips ? write_strips(*source, *window, file, options, globals)
                                     : write_whole(*source, *window, file, options, globals);
    if (!written.ok()) return written.error();
    const std::optional<double> bound = source->bound();
    Outcome outcome;
    outcome.json = Json{{"samples", window->rows * window->cols},
                        {"bytes_read", file.bytes_read()},
                        {"level", options.level},
                        {"bound", bound ? json_number(*bound) : Json(nullptr)},
                        {"rows", window->rows},
                        {"cols", window->cols},
                        {"finest_level", file.finest_level()},
                        {"damaged", damage_json(source->damaged())},
                        {"seconds", watch.seconds()}};
    outcome.text = fmt::format("{}: {} x {} samples of level {}, {} bytes read\n", options.out,
                               window->cols, window->rows, options.level,
                               grouped(static_cast<std::int64_t>(file.bytes_read())));
    if (bound) outcome.text += fmt::format("within {} of the original\n", shown(*bound));
    if (!source->damaged().empty())
        outcome.text += fmt::format("{} damaged tiles were filled in from coarser levels\n",
                                    source->damaged().size());
    return outcome;
}

}  // namespace

void add_decode(Program& program) {
    auto options = std::make_shared<Decode>();
    CLI::App* verb = add_verb(
        program, "decode",
        "Turn a .relief file back into a raster, whole, coarser, finer or in part; into a mesh, "
        "Bezier triangles or a table.",
        "  relief decode dem.relief dem.tif\n"
        "  relief decode dem.relief overview.tif --level 3\n"
        "  relief decode dem.relief smooth.tif --scale 4 --window 0,0,512,512\n"
        "  relief decode model.relief coarse.obj --level 2\n"
        "  relief decode survey.relief dem.tif --cell 0.5\n"
        "  relief decode survey.relief survey.vtu",
        [options, &program] { return run(*options, program.globals); });
    verb->add_option("IN", options->in, "the .relief file")->required();
    verb->add_option("OUT", options->out,
                     "the raster or mesh; its extension names the format (.tif: GeoTIFF, .off, "
                     ".obj, .ply, ..); of a spline on triangles also .vtu (Bezier triangles for "
                     "ParaView) and .csv (vertices with value and gradient)")
        ->required();
    verb->add_option(
            "--level", options->level,
            "level below the finest: every 2^K-th sample, or the mesh K refinements coarser; 0: "
            "all")
        ->check(CLI::Range(0, 64));
    verb->add_option("--bytes", options->bytes, "read only this many bytes of the file");
    verb->add_option("--window", options->window, "COL,ROW,WIDTH,HEIGHT in samples of the result")
        ->delimiter(',')
        ->expected(4);
    verb->add_flag("--allow-damage", options->allow_damage,
                   "fill damaged tiles in from coarser levels, and say which");
    verb->add_option("--cell", options->cell,
                     "splines on triangles: size of the raster's cells, in data units; default: "
                     "about one cell a vertex");
    verb->add_option("--scale", options->scale,
                     "samples a side relative to the original: the spline evaluated anywhere");
}

}  // namespace relief::cli
