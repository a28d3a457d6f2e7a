#include <fmt/format.h>

#include <cmath>

#include "command.h"
#include "relief/io/raster.h"
#include "relief/multires/surface.h"

namespace relief::cli {

namespace {

struct Decode {
    std::string in;
    std::string out;
    int level = 0;
    std::optional<std::int64_t> bytes;
    std::vector<std::int64_t> window;
    double scale = 1;
};

/// A part of a raster; the transform moves along.
Result<Raster> cropped(Raster raster, const std::vector<std::int64_t>& window) {
    const std::int64_t col = window[0], row = window[1], cols = window[2], rows = window[3];
    if (cols < 1 || rows < 1 || col < 0 || row < 0 || col > raster.cols - cols ||
        row > raster.rows - rows)
        return Error{ErrorCode::InvalidArgument,
                     fmt::format("the window {},{},{},{} is not inside the {} x {} raster", col,
                                 row, cols, rows, raster.cols, raster.rows),
                     ""};
    for (Grid<double>& plane : raster.planes) {
        Grid<double> part(rows, cols);
        for (std::int64_t r = 0; r < rows; ++r)
            std::copy_n(plane.row(row + r) + col, cols, part.row(r));
        plane = std::move(part);
    }
    if (!raster.mask.empty()) {
        Grid<std::uint8_t> part(rows, cols);
        for (std::int64_t r = 0; r < rows; ++r)
            std::copy_n(raster.mask.row(row + r) + col, cols, part.row(r));
        raster.mask = std::move(part);
    }
    if (raster.geo.transform) {
        auto& t = *raster.geo.transform;
        t[0] += static_cast<double>(col) * t[1] + static_cast<double>(row) * t[2];
        t[3] += static_cast<double>(col) * t[4] + static_cast<double>(row) * t[5];
    }
    raster.rows = rows;
    raster.cols = cols;
    return raster;
}

/// The surface at another sampling: `scale` times as many samples a side over the same ground.
/// Below 1 the level whose spacing is the nearest finer one is sampled, so that nothing aliases.
Result<Raster> rescaled(const codec::RasterFile& file, double scale) {
    const auto& layout = file.layout();
    int level = 0;
    while (level < layout.levels() && std::ldexp(1.0, level + 1) <= 1 / scale) ++level;
    RELIEF_TRY(Raster raster, file.decode(level));
    multires::LevelCoefficients<double> net;
    if (level == 0) {
        RELIEF_TRY(net.planes, file.control_net());
        net.box = {0, 0, layout.rows, layout.cols};
    } else {
        RELIEF_TRY(net, file.coefficients(level));
    }
    const double rows = std::ceil(static_cast<double>(layout.rows) * scale - 1e-9);
    const double cols = std::ceil(static_cast<double>(layout.cols) * scale - 1e-9);
    if (rows > 1e6 || cols > 1e6 || rows * cols > 4e9)
        return Error{ErrorCode::InvalidArgument, "--scale makes the raster too large", ""};
    Raster result;
    result.rows = std::max<std::int64_t>(1, static_cast<std::int64_t>(rows));
    result.cols = std::max<std::int64_t>(1, static_cast<std::int64_t>(cols));
    // Sample r lies at (r + 1/2) / scale - 1/2 of the finest raster: cells cover the same ground.
    const double step = 1 / scale;
    const double first = 0.5 * step - 0.5;
    const double unit = std::ldexp(1.0, -level);
    for (const Grid<double>& plane : net.planes) {
        RELIEF_TRY(const auto surface,
                   multires::Surface<double>::create(layout.spec, plane.view()));
        Grid<double> samples(result.rows, result.cols);
        surface.evaluate_grid(first * unit - static_cast<double>(net.box.row0), step * unit,
                              first * unit - static_cast<double>(net.box.col0), step * unit,
                              samples.view());
        result.planes.push_back(std::move(samples));
    }
    const Raster& about = file.description();
    result.type = is_integer(about.type) ? SampleType::Float32 : about.type;
    result.nodata = about.nodata;
    result.geo = about.geo;
    if (result.geo.transform)
        for (const std::size_t k : {1U, 2U, 4U, 5U}) (*result.geo.transform)[k] *= step;
    result.unit = about.unit;
    result.scale = about.scale;
    result.offset = about.offset;
    result.band_names = about.band_names;
    result.metadata = about.metadata;
    if (!file.mask().empty()) result.mask = Grid<std::uint8_t>(result.rows, result.cols);
    for (std::int64_t r = 0; r < result.rows; ++r)
        for (std::int64_t c = 0; c < result.cols; ++c) {
            if (result.mask.empty()) continue;
            const auto at = [&](std::int64_t k, std::int64_t n) {
                return std::clamp<std::int64_t>(std::llround(first + static_cast<double>(k) * step),
                                                0, n - 1);
            };
            result.mask(r, c) = file.mask()(at(r, layout.rows), at(c, layout.cols));
            if (!result.mask(r, c))
                for (Grid<double>& plane : result.planes) plane(r, c) = NAN;
        }
    for (Grid<double>& plane : result.planes)
        for (std::int64_t r = 0; r < result.rows; ++r)
            for (std::int64_t c = 0; c < result.cols; ++c)
                if (result.valid(r, c))
                    plane(r, c) = stored_value(plane(r, c), result.type, result.nodata);
    return result;
}

/// What a reader of the raster, and `relief compare`, may want to know of its origin. What an
/// earlier encoding said of itself goes.
void describe(const codec::RasterFile& file, std::optional<double> bound, Raster& raster) {
    const auto& spec = file.layout().spec;
    std::erase_if(raster.metadata,
                  [](const auto& item) { return item.first.starts_with("RELIEF_"); });
    raster.metadata.emplace_back(
        "RELIEF_SCHEME", fmt::format("{} order {}", multires::scheme_name(spec.id), spec.order));
    raster.metadata.emplace_back("RELIEF_LEVELS", std::to_string(spec.levels));
    if (bound) raster.metadata.emplace_back("RELIEF_MAX_ERROR", fmt::format("{}", *bound));
}

Result<Outcome> run(const Decode& options, const Globals& globals) {
    const Stopwatch watch;
    if (!(options.scale > 0 && std::isfinite(options.scale)))
        return Error{ErrorCode::InvalidArgument, "--scale must be a positive number", ""};
    if (options.scale != 1 && options.level != 0)
        return Error{ErrorCode::InvalidArgument, "--scale and --level exclude each other", ""};
    if (options.bytes && *options.bytes < 1)
        return Error{ErrorCode::InvalidArgument, "--bytes must be at least 1", ""};
    RELIEF_TRY(const codec::RasterFile file, open_relief(options.in, options.bytes));
    auto decoded = options.scale == 1 ? file.decode(options.level) : rescaled(file, options.scale);
    if (!decoded.ok()) return located(decoded.error(), options.in);
    Raster raster = *std::move(decoded);
    if (!options.window.empty()) {
        RELIEF_TRY(raster, cropped(std::move(raster), options.window));
    }
    std::optional<double> bound;
    if (options.scale == 1) bound = file.bound(options.level);
    describe(file, bound, raster);
    RELIEF_CHECK(
        io::write_raster(options.out, raster, {.progress = progress_bar(globals, "writing")}));
    Outcome outcome;
    outcome.json = Json{{"samples", raster.rows * raster.cols},
                        {"bytes_read", file.bytes_for(options.level)},
                        {"level", options.level},
                        {"bound", bound ? json_number(*bound) : Json(nullptr)},
                        {"rows", raster.rows},
                        {"cols", raster.cols},
                        {"finest_level", file.finest_level()},
                        {"seconds", watch.seconds()}};
    outcome.text = fmt::format("{}: {} x {} samples of level {}, {} bytes read\n", options.out,
                               raster.cols, raster.rows, options.level,
                               grouped(static_cast<std::int64_t>(file.bytes_for(options.level))));
    if (bound) outcome.text += fmt::format("within {} of the original\n", shown(*bound));
    return outcome;
}

}  // namespace

void add_decode(Program& program) {
    auto options = std::make_shared<Decode>();
    CLI::App* verb =
        add_verb(program, "decode",
                 "Turn a .relief file back into a raster, whole, coarser, finer or in part.",
                 "  relief decode dem.relief dem.tif\n"
                 "  relief decode dem.relief overview.tif --level 3\n"
                 "  relief decode dem.relief smooth.tif --scale 4 --window 0,0,512,512",
                 [options, &program] { return run(*options, program.globals); });
    verb->add_option("IN", options->in, "the .relief file")->required();
    verb->add_option("OUT", options->out,
                     "the raster; its extension names the format (.tif: GeoTIFF)")
        ->required();
    verb->add_option("--level", options->level,
                     "level below the finest: every 2^K-th sample; 0: all")
        ->check(CLI::Range(0, 64));
    verb->add_option("--bytes", options->bytes, "read only this many bytes of the file");
    verb->add_option("--window", options->window, "COL,ROW,WIDTH,HEIGHT in samples of the result")
        ->delimiter(',')
        ->expected(4);
    verb->add_option("--scale", options->scale,
                     "samples a side relative to the original: the spline evaluated anywhere");
}

}  // namespace relief::cli
