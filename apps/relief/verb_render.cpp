#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "command.h"
#include "relief/io/file_kind.h"
#include "relief/io/picture.h"
#include "relief/io/png.h"
#include "relief/io/wireframe.h"

namespace relief::cli {

namespace {

struct Render {
    std::string in;
    std::string out;
    int width = 0;
    std::string style = "hillshade";
    std::string reference;
    std::string drape;
    std::optional<int> level;
    double exaggeration = 0;
    double azimuth = 315;
    double altitude = 45;
    double scale = 0;
    bool multidirectional = false;
};

io::Mask mask_of(const Raster& raster) {
    return raster.mask.empty() ? io::Mask{} : raster.mask.view();
}

bool is_parametric(const Raster& raster) {
    return raster.planes.size() == 3;
}

int picture_width(const Render& options, const Raster& raster) {
    if (options.width > 0) return options.width;
    return static_cast<int>(std::clamp<std::int64_t>(raster.cols, 800, 2048));
}

io::LightOptions light_of(const Render& options) {
    return {.azimuth = options.azimuth,
            .altitude = options.altitude,
            .vertical_exaggeration = options.exaggeration,
            .multidirectional = options.multidirectional};
}

/// A three-band raster as the surface in space it is, with its grid lines.
io::Image draw_parametric(const Raster& raster, int width) {
    const io::Sheet sheet = io::point_sheet(raster.planes[0].view(), raster.planes[1].view(),
                                            raster.planes[2].view(), mask_of(raster));
    io::SheetStyle style;
    style.fill = io::SheetFill::Paper;
    style.line_every =
        static_cast<int>(std::max<std::int64_t>(1, std::max(raster.rows, raster.cols) / 60));
    style.line_opacity = 0.5;
    const io::Layer layer{&sheet, style};
    return io::draw_sheets({&layer, 1}, {.width = width});
}

/// The surface with the control net of a level over it.
Result<io::Image> draw_net(const Render& options, const codec::RasterFile& file, int level,
                           const io::ViewOptions& view) {
    const auto& layout = file.layout();
    const int surface_level = std::max(0, level - 1);
    RELIEF_TRY(const Raster surface, file.decode(surface_level));
    RELIEF_TRY(const auto net, file.coefficients(level));
    const io::CellSize cell = io::cell_size_metres(file.description().geo, layout.rows);
    const auto sheet_of = [&](io::Heights z, io::Mask mask, int at, const LatticeBox& box,
                              double exaggeration) {
        const double step = std::ldexp(1.0, at);
        return io::height_sheet(z, mask, {cell.x * step, cell.y * step}, exaggeration,
                                {static_cast<double>(box.col0) * step * cell.x,
                                 static_cast<double>(box.row0) * step * cell.y});
    };
    const double coarse = std::ldexp(1.0, surface_level);
    const double exaggeration =
        options.exaggeration > 0 ? options.exaggeration
                                 : io::auto_exaggeration(surface.planes[0].view(), mask_of(surface),
                                                         {cell.x * coarse, cell.y * coarse});
    const io::Sheet ground = sheet_of(surface.planes[0].view(), mask_of(surface), surface_level,
                                      {0, 0, 0, 0}, exaggeration);
    const io::Sheet lines = sheet_of(net.planes[0].view(), {}, level, net.box, exaggeration);
    io::SheetStyle ground_style;
    ground_style.fill = io::SheetFill::ByHeight;
    io::SheetStyle line_style;
    line_style.fill = io::SheetFill::None;
    line_style.line_every = 1;
    line_style.line_colour = {150, 20, 30};
    line_style.dot_radius = std::max(net.box.rows, net.box.cols) < 120 ? 2.5 : 0;
    const io::Layer layers[] = {{&ground, ground_style}, {&lines, line_style}};
    return io::draw_sheets(layers, view);
}

Result<io::Image> draw(const Render& options, const Raster& raster, const Globals& globals) {
    if (raster.valid_count() == 0)
        return Error{ErrorCode::BadInput, "no sample is valid: there is nothing to draw",
                     options.in};
    const int width = picture_width(options, raster);
    const io::CellSize cell = io::cell_size_metres(raster.geo, raster.rows);
    const io::PictureOptions picture{.light = light_of(options), .width = width};
    const io::Heights z = raster.planes.back().view();
    if (!options.drape.empty()) {
        RELIEF_TRY(const io::Image image, io::read_png(options.drape));
        return io::drape(z, mask_of(raster), cell, image, picture);
    }
    if (options.style == "error") {
        if (options.reference.empty())
            return Error{ErrorCode::InvalidArgument, "--style error needs --reference FILE", ""};
        RELIEF_TRY(const Raster reference, read_any_raster(options.reference, globals));
        if (reference.rows != raster.rows || reference.cols != raster.cols)
            return Error{ErrorCode::BadInput,
                         fmt::format("is {} x {}, the surface {} x {}", reference.cols,
                                     reference.rows, raster.cols, raster.rows),
                         options.reference};
        return io::error_map(z, reference.planes.back().view(), mask_of(raster), cell,
                             {.scale = options.scale, .unit = raster.unit, .picture = picture});
    }
    if (options.style == "colour") return io::colour_by_height(z, mask_of(raster), cell, picture);
    if (options.style == "wire") {
        if (is_parametric(raster)) return draw_parametric(raster, width);
        return io::wireframe(z, mask_of(raster), cell,
                             {.width = width, .light = light_of(options)});
    }
    return io::hillshade(z, mask_of(raster), cell, picture);
}

Result<Outcome> run(const Render& options, const Globals& globals) {
    io::Image image;
    const bool relief_file = io::recognise(options.in) == io::FileKind::Relief;
    if (options.level && !relief_file)
        return Error{ErrorCode::InvalidArgument, "--level needs a .relief file", ""};
    if (options.level) {
        RELIEF_TRY(const codec::RasterFile file, open_relief(options.in));
        if (*options.level > file.layout().levels()) return file.decode(*options.level).error();
        if (options.style == "wire" && file.layout().components == 1) {
            const int width = options.width > 0 ? options.width : 1200;
            RELIEF_TRY(image, draw_net(options, file, *options.level,
                                       {.width = width, .light = light_of(options)}));
        } else {
            RELIEF_TRY(const Raster raster, file.decode(*options.level));
            RELIEF_TRY(image, draw(options, raster, globals));
        }
    } else {
        RELIEF_TRY(const Raster raster, read_any_raster(options.in, globals));
        RELIEF_TRY(image, draw(options, raster, globals));
    }
    RELIEF_CHECK(io::write_png(options.out, image));
    Outcome outcome;
    outcome.json = Json{{"width", image.width}, {"height", image.height}};
    outcome.text = fmt::format("{}: {} x {} pixels\n", options.out, image.width, image.height);
    return outcome;
}

}  // namespace

void add_render(Program& program) {
    auto options = std::make_shared<Render>();
    CLI::App* verb = add_verb(
        program, "render", "Draw a raster or a .relief file as a PNG picture, without a screen.",
        "  relief render dem.relief hills.png --width 1200\n"
        "  relief render dem.relief error.png --style error --reference dem.tif\n"
        "  relief render dem.relief net.png --style wire --level 4",
        [options, &program] { return run(*options, program.globals); });
    verb->add_option(
            "IN", options->in,
            "a raster or a .relief file; three bands are drawn as a surface in space by wire")
        ->required();
    verb->add_option("OUT", options->out, "the .png file")->required();
    verb->add_option(
            "--width", options->width,
            "pixels across, error at least 180; default: the raster's columns, at least 800")
        ->check(CLI::Range(16, 16384));
    verb->add_option("--style", options->style, "hillshade (default), colour, wire, error")
        ->check(CLI::IsMember({"hillshade", "colour", "wire", "error"}));
    verb->add_option("--reference", options->reference,
                     "what the error is measured against (error)");
    verb->add_option("--drape", options->drape,
                     "a PNG laid over the ground, stretched to the raster's extent");
    verb->add_option("--level", options->level,
                     "draw this level of a .relief file; with wire its control net");
    verb->add_option("--scale", options->scale,
                     "difference at the ends of the colours (error); default: the largest");
    verb->add_option("--exaggeration", options->exaggeration,
                     "vertical factor; default: from the mean slope");
    verb->add_option("--azimuth", options->azimuth,
                     "of the light, degrees clockwise from north (default 315)");
    verb->add_option("--altitude", options->altitude,
                     "of the light, degrees above the horizon (default 45)");
    verb->add_flag("--multidirectional", options->multidirectional, "four lights instead of one");
}

}  // namespace relief::cli
