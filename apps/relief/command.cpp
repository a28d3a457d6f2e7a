#include "command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>

#include "level_files.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"
#include "relief/io/raster.h"

namespace relief::cli {

namespace {

std::atomic<bool> g_stop{false};

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

}  // namespace

CLI::App* add_verb(Program& program, const std::string& name, const std::string& description,
                   const std::string& examples, Run run) {
    CLI::App* verb = program.app.add_subcommand(name, description);
    verb->footer("Examples:\n" + examples);
    Globals& globals = program.globals;
    verb->add_flag("--json", globals.json, "print one JSON object on standard output");
    verb->add_flag("-q,--quiet", globals.quiet, "print errors only");
    verb->add_flag("-v,--verbose", globals.verbose, "say more");
    verb->add_option("--threads", globals.threads,
                     "threads to use; 0: all cores (results do not depend on it)")
        ->check(CLI::Range(0, 1024));
    verb->callback([&program, name, run = std::move(run)] {
        program.verb = name;
        program.chosen = run;
    });
    return verb;
}

void stop_on_interrupt() {
    const auto stop = [](int) { g_stop = true; };
    std::signal(SIGINT, stop);
    std::signal(SIGTERM, stop);
}

Progress progress_bar(const Globals& globals, std::string what) {
    const bool shown_on_terminal = !globals.quiet && isatty(STDERR_FILENO) == 1;
    return [what = std::move(what), shown_on_terminal, last = -1](double done) mutable {
        const int percent = static_cast<int>(100 * std::clamp(done, 0.0, 1.0));
        if (shown_on_terminal && percent > last) {
            last = percent;
            fmt::print(stderr, "\r{} {:3} %", what, percent);
            if (percent == 100) fmt::print(stderr, "\r{:{}}\r", "", what.size() + 6);
        }
        return !g_stop.load();
    };
}

std::string shown(double value) {
    return fmt::format("{:.6g}", value);
}

std::string grouped(std::int64_t value) {
    std::string digits = std::to_string(value);
    for (auto at = static_cast<std::int64_t>(digits.size()) - 3; at > (value < 0 ? 1 : 0); at -= 3)
        digits.insert(static_cast<std::size_t>(at), " ");
    return digits;
}

Json json_number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json json_number(const std::optional<double>& value) {
    return value ? json_number(*value) : Json(nullptr);
}

Stopwatch::Stopwatch() : start_(now()) {}
double Stopwatch::seconds() const {
    return now() - start_;
}

void add_length(CLI::App& options, const std::string& name, std::optional<double>& length,
                bool& of_diagonal, const std::string& description) {
    options
        .add_option_function<std::string>(
            name,
            [name, &length, &of_diagonal](const std::string& text) {
                of_diagonal = text.size() > 1 && text.back() == 'd';
                double value = 0;
                if (!CLI::detail::lexical_cast(text.substr(0, text.size() - of_diagonal), value))
                    throw CLI::ConversionError(text, name);
                length = value;
            },
            description)
        ->type_name("FLOAT");
}

void SchemeOptions::add_to(CLI::App& app) {
    // The names are checked where they are understood, which says more than CLI::IsMember.
    app.add_option(
           "--scheme", scheme,
           "rasters: fvs (best for --max-error and --lossless), cubic (best for the other "
           "goals), box, barycentric; meshes: loop, sqrt3, catmull-clark, and over the plane fvs "
           "for quads, powell-sabin for triangles")
        ->type_name("TEXT:{fvs,cubic,box,barycentric,loop,sqrt3,catmull-clark,powell-sabin}");
    app.add_option(
        "--order", order,
        "1: linear C0, 2: quartic C2 (default); barycentric also 3: C4, 4: C6; cubic has 2");
    app.add_option("--levels", levels, "levels of detail; default: as many as the raster allows");
    app.add_option("--family", family, "barycentric: which filters (default compact)")
        ->type_name("TEXT:{compact,semi-orthogonal,truncated,truncated-literal}");
    app.add_option("--dual", dual,
                   "barycentric compact: order of the dual spline; default: as --order");
    app.add_option("--map", map, "how samples and surface meet (default interpolate)")
        ->type_name("TEXT:{interpolate,quasi-interpolate,coefficients}");
    app.add_flag("--exact", exact, "cubic: the whole spline by recursion, not its taps cut at six");
}

Result<std::optional<multires::SchemeSpec>> SchemeOptions::spec() const {
    const SchemeOptions defaults;
    const bool untouched = order == defaults.order && levels == defaults.levels &&
                           family == defaults.family && dual == defaults.dual &&
                           map == defaults.map && exact == defaults.exact;
    if (scheme.empty() && untouched) return std::optional<multires::SchemeSpec>();
    multires::SchemeSpec spec;
    RELIEF_TRY(spec.id, multires::scheme_from_name(scheme.empty() ? "box" : scheme));
    RELIEF_TRY(spec.family, multires::family_from_name(family));
    RELIEF_TRY(spec.data_map, multires::data_map_from_name(map));
    if (levels < -1) return Error{ErrorCode::InvalidArgument, "--levels must not be negative", ""};
    spec.order = order;
    spec.levels = levels;
    spec.dual_order = dual;
    spec.exact = exact;
    return std::optional(spec);
}

Error located(Error error, const std::string& path) {
    error.where = error.where.empty() ? path : path + ", " + error.where;
    return error;
}

Result<codec::RasterFile> open_relief(const std::string& path,
                                      std::optional<std::uint64_t> max_bytes) {
    return open_file<codec::RasterFile>(path, max_bytes);
}

namespace {

/// A raster in memory that belongs to its source.
class OwnedRaster final : public RasterSource {
  public:
    explicit OwnedRaster(Raster raster) : raster_(std::move(raster)), view_(raster_) {}
    [[nodiscard]] const Raster& description() const override { return view_.description(); }
    [[nodiscard]] int components() const override { return view_.components(); }
    [[nodiscard]] Result<Raster> read(const LatticeBox& window) const override {
        return view_.read(window);
    }

  private:
    Raster raster_;
    MemoryRaster view_;
};

}  // namespace

Result<std::unique_ptr<RasterSource>> open_raster(const std::string& path, const Globals& globals) {
    if (io::recognise(path) == io::FileKind::Raster) {
        RELIEF_TRY(io::RasterReader reader, io::RasterReader::open(path));
        return std::unique_ptr<RasterSource>(std::make_unique<io::RasterReader>(std::move(reader)));
    }
    RELIEF_TRY(Raster raster, read_any_raster(path, globals));
    return std::unique_ptr<RasterSource>(std::make_unique<OwnedRaster>(std::move(raster)));
}

Result<Raster> read_any_raster(const std::string& path, const Globals& globals) {
    switch (io::recognise(path)) {
        case io::FileKind::Relief: {
            RELIEF_TRY(const codec::RasterFile file, open_relief(path));
            auto raster = file.decode(0);
            if (!raster.ok()) return located(raster.error(), path);
            return raster;
        }
        case io::FileKind::Mesh:
            return Error{ErrorCode::Unsupported, "is a mesh; this version reads rasters", path};
        case io::FileKind::Points:
            return Error{ErrorCode::Unsupported,
                         "holds scattered points; 'relief fit' makes a surface of them", path};
        default:
            return io::read_raster(path, {.progress = progress_bar(globals, "reading")});
    }
}

}  // namespace relief::cli
