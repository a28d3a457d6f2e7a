#include <fmt/format.h>

#include <cmath>

#include "command.h"
#include "mesh_verbs.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/codec/raster_surface.h"
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

/// The surface at another sampling: `scale` times as many samples a side over the same ground.
/// Below 1 the level whose spacing is the nearest finer one is sampled, so that nothing aliases.
class Rescaled {
  public:
    static Result<Rescaled> create(const codec::RasterFile& file, double scale) {
        Rescaled scaled(file, scale);
        const Raster& about = file.description();
        while (scaled.level_ < file.layout().levels() &&
               std::ldexp(1.0, scaled.level_ + 1) <= 1 / scale)
            ++scaled.level_;
        const double rows = std::ceil(static_cast<double>(about.rows) * scale - 1e-9);
        const double cols = std::ceil(static_cast<double>(about.cols) * scale - 1e-9);
        if (rows > INT32_MAX || cols > INT32_MAX)
            return Error{ErrorCode::InvalidArgument, "--scale makes the raster too large", ""};
        scaled.box_ = {0, 0, std::max<std::int64_t>(1, static_cast<std::int64_t>(rows)),
                       std::max<std::int64_t>(1, static_cast<std::int64_t>(cols))};
        return scaled;
    }

    [[nodiscard]] const LatticeBox& box() const { return box_; }

    [[nodiscard]] Result<Raster> window(const LatticeBox& part) const {
        RELIEF_TRY(const auto surface,
                   codec::RasterSurface::create(file_, level_, level_box(part)));
        Raster result = description(part);
        const double step = std::ldexp(1 / scale_, -level_);
        for (int c = 0; c < surface.components(); ++c) {
            Grid<double> samples(part.rows, part.cols);
            surface.evaluate_grid(c, row(part.row0), step, col(part.col0), step, samples.view());
            result.planes.push_back(std::move(samples));
        }
        result.mask = Grid<std::uint8_t>(part.rows, part.cols);
        for (std::int64_t r = 0; r < part.rows; ++r)
            for (std::int64_t c = 0; c < part.cols; ++c)
                result.mask(r, c) = surface.valid(row(part.row0 + r), col(part.col0 + c));
        store(result);
        return result;
    }

  private:
    Rescaled(const codec::RasterFile& file, double scale) : file_(file), scale_(scale) {}

    /// Sample r lies at (r + 1/2) / scale - 1/2 of the finest raster, so that cells cover the same
    /// ground; here in samples of the level, `margin` in front of them.
    [[nodiscard]] double place(std::int64_t r, std::int64_t margin) const {
        const double finest = (static_cast<double>(r) + 0.5) / scale_ - 0.5;
        if (level_ == 0) return finest;
        return std::ldexp(finest + static_cast<double>(margin), -level_);
    }
    [[nodiscard]] double row(std::int64_t r) const { return place(r, file_.margin().rows); }
    [[nodiscard]] double col(std::int64_t c) const { return place(c, file_.margin().cols); }

    /// Samples of the level around a window.
    [[nodiscard]] LatticeBox level_box(const LatticeBox& part) const {
        const LatticeBox all = file_.box(level_);
        const auto between = [&](std::int64_t first, std::int64_t count, std::int64_t n,
                                 std::int64_t margin) {
            const auto low = static_cast<std::int64_t>(std::floor(place(first, margin)));
            const auto high =
                static_cast<std::int64_t>(std::ceil(place(first + count - 1, margin)));
            const std::int64_t begin = std::clamp<std::int64_t>(low, 0, n - 1);
            return std::pair{begin, std::clamp<std::int64_t>(high, begin, n - 1) - begin + 1};
        };
        const auto [row0, rows] = between(part.row0, part.rows, all.rows, file_.margin().rows);
        const auto [col0, cols] = between(part.col0, part.cols, all.cols, file_.margin().cols);
        return {row0, col0, rows, cols};
    }

    [[nodiscard]] Raster description(const LatticeBox& part) const {
        Raster result = description_of(file_.description());
        result.rows = part.rows;
        result.cols = part.cols;
        if (is_integer(result.type)) result.type = SampleType::Float32;
        if (!result.geo.transform) return result;
        auto& t = *result.geo.transform;
        for (const std::size_t k : {1U, 2U, 4U, 5U}) t[k] /= scale_;
        t[0] += static_cast<double>(part.col0) * t[1] + static_cast<double>(part.row0) * t[2];
        t[3] += static_cast<double>(part.col0) * t[4] + static_cast<double>(part.row0) * t[5];
        return result;
    }

    static void store(Raster& raster) {
        bool holes = false;
        for (Grid<double>& plane : raster.planes)
            for (std::int64_t r = 0; r < raster.rows; ++r) {
                stored_row(plane.row(r), raster.cols, raster.type, raster.nodata, plane.row(r));
                for (std::int64_t c = 0; c < raster.cols; ++c) {
                    if (raster.valid(r, c)) continue;
                    plane(r, c) = NAN;
                    holes = true;
                }
            }
        if (!holes) raster.mask = {};
    }

    const codec::RasterFile& file_;
    double scale_;
    int level_ = 0;
    LatticeBox box_;
};

/// What a reader of the raster, and `relief compare`, may want to know of its origin. What an
/// earlier encoding said of itself goes.
void describe(const codec::RasterFile& file, std::optional<double> bound, Raster& raster) {
    const auto& spec = file.spec();
    std::erase_if(raster.metadata,
                  [](const auto& item) { return item.first.starts_with("RELIEF_"); });
    raster.metadata.emplace_back(
        "RELIEF_SCHEME", fmt::format("{} order {}", multires::scheme_name(spec.id), spec.order));
    raster.metadata.emplace_back("RELIEF_LEVELS", std::to_string(spec.levels));
    if (bound) raster.metadata.emplace_back("RELIEF_MAX_ERROR", fmt::format("{}", *bound));
}

/// Samples of a window of what was asked for.
class Source {
  public:
    static Result<Source> create(const codec::RasterFile& file, const Decode& options) {
        Source source(file, options);
        source.box_ = file.box(std::min(options.level, file.layout().levels()));
        if (options.level > file.layout().levels()) return file.decode(options.level).error();
        if (options.scale != 1) {
            RELIEF_TRY(Rescaled rescaled, Rescaled::create(file, options.scale));
            source.rescaled_.emplace(std::move(rescaled));
            source.box_ = source.rescaled_->box();
        }
        return source;
    }

    [[nodiscard]] const LatticeBox& box() const { return box_; }

    [[nodiscard]] Result<Raster> window(const LatticeBox& part) {
        if (rescaled_) return rescaled_->window(part);
        RELIEF_TRY(codec::DecodedRaster decoded, file_.decode_window(options_.level, part));
        if (!decoded.damaged.empty() && !options_.allow_damage) {
            const LatticeBox& first = decoded.damaged.front();
            return Error{ErrorCode::BadFile,
                         fmt::format("chunks of columns {} to {}, rows {} to {}{} are damaged; "
                                     "--allow-damage fills them in from coarser ones",
                                     first.col0, first.col0 + first.cols - 1, first.row0,
                                     first.row0 + first.rows - 1,
                                     decoded.damaged.size() > 1 ? " and of more tiles" : ""),
                         ""};
        }
        damaged_.insert(damaged_.end(), decoded.damaged.begin(), decoded.damaged.end());
        bound_ = bound_ && decoded.bound ? std::optional(std::max(*bound_, *decoded.bound))
                                         : std::nullopt;
        return std::move(decoded.raster);
    }

    /// Of all windows so far.
    [[nodiscard]] std::optional<double> bound() const { return rescaled_ ? std::nullopt : bound_; }
    [[nodiscard]] const std::vector<LatticeBox>& damaged() const { return damaged_; }

  private:
    Source(const codec::RasterFile& file, const Decode& options) : file_(file), options_(options) {}

    const codec::RasterFile& file_;
    const Decode& options_;
    LatticeBox box_;
    std::optional<Rescaled> rescaled_;
    std::optional<double> bound_ = 0;
    std::vector<LatticeBox> damaged_;
};

Status write_whole(Source& source, const LatticeBox& window, const codec::RasterFile& file,
                   const Decode& options, const Globals& globals) {
    auto decoded = source.window(window);
    if (!decoded.ok()) return located(decoded.error(), options.in);
    describe(file, source.bound(), *decoded);
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
            describe(file, options.allow_damage ? std::nullopt : file.bound(options.level), about);
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
