#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "command.h"
#include "mesh_verbs.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/io/file_kind.h"
#include "relief/io/mesh_picture.h"
#include "relief/io/picture.h"
#include "relief/io/png.h"
#include "relief/io/wireframe.h"
#include "relief/mesh/closest.h"
#include "relief/multires/surface.h"

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
    std::optional<double> scale;
    bool of_diagonal = false;  ///< scale is
    bool multidirectional = false;
    std::string caption;
    std::string up = "z";
    std::optional<double> viewer;
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

/// A three-band raster as the surface in space it is, with about `lines` grid lines each way.
io::Image draw_parametric(const Raster& raster, int width, int lines) {
    const io::Sheet sheet = io::point_sheet(raster.planes[0].view(), raster.planes[1].view(),
                                            raster.planes[2].view(), mask_of(raster));
    io::SheetStyle style;
    style.fill = io::SheetFill::Paper;
    if (lines > 0)
        style.line_every =
            static_cast<int>(std::max<std::int64_t>(1, std::max(raster.rows, raster.cols) / lines));
    style.line_opacity = 0.5;
    const io::Layer layer{&sheet, style};
    return io::draw_sheets({&layer, 1}, {.width = width});
}

/// The surface of a level, finer details left out, at the raster's samples.
Result<Raster> level_surface(const codec::RasterFile& file, int level) {
    RELIEF_TRY(Raster raster, file.decode(0));
    if (level == 0) return raster;
    RELIEF_TRY(auto net, file.coefficients(level));
    const auto& layout = file.layout();
    if (!file.closed_loop()) {
        raster.planes =
            multires::samples_of(layout, multires::subdivide(layout, std::move(net), level, 0), 0);
        return raster;
    }
    const double step = std::ldexp(1.0, -level);
    for (std::size_t p = 0; p < raster.planes.size(); ++p) {
        RELIEF_TRY(const auto surface,
                   multires::Surface<double>::create(file.spec(), net.planes[p].view()));
        surface.evaluate_grid(static_cast<double>(file.margin().rows) * step, step,
                              static_cast<double>(file.margin().cols) * step, step,
                              raster.planes[p].view());
    }
    return raster;
}

/// The surface of a level with its control net over it.
io::Image draw_net(const Render& options, const Raster& surface,
                   const multires::LevelCoefficients<double>& net, int level,
                   codec::LatticeMargin margin) {
    const int width = options.width > 0 ? options.width : 1200;
    const io::CellSize cell = io::cell_size_metres(surface.geo, surface.rows);
    const io::Heights z = surface.planes[0].view();
    const double exaggeration = options.exaggeration > 0
                                    ? options.exaggeration
                                    : io::auto_exaggeration(z, mask_of(surface), cell);
    const std::int64_t every =
        std::max<std::int64_t>(1, std::max(surface.rows, surface.cols) / width);
    const io::Sheet ground =
        io::height_sheet(z, mask_of(surface), cell, exaggeration, {0, 0}, every);
    const double step = std::ldexp(1.0, level);
    const auto place = [step](std::int64_t first, std::int64_t before) {
        return static_cast<double>(first) * step - static_cast<double>(before);
    };
    const io::Sheet lines = io::height_sheet(
        net.planes[0].view(), {}, {cell.x * step, cell.y * step}, exaggeration,
        {place(net.box.col0, margin.cols) * cell.x, place(net.box.row0, margin.rows) * cell.y});
    io::SheetStyle line_style;
    line_style.fill = io::SheetFill::None;
    line_style.line_every = 1;
    line_style.line_colour = {150, 20, 30};
    line_style.line_width = std::clamp(width / 1200.0, 0.6, 1.0);
    line_style.dot_radius =
        std::max(net.box.rows, net.box.cols) < width / 12 ? std::clamp(width / 480.0, 1.0, 2.5) : 0;
    const io::Layer layers[] = {{&ground, {.fill = io::SheetFill::ByHeight}}, {&lines, line_style}};
    return io::draw_sheets(layers, {.width = width, .light = light_of(options)});
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
        return io::error_map(
            z, reference.planes.back().view(), mask_of(raster), cell,
            {.scale = options.scale.value_or(0), .unit = raster.unit, .picture = picture});
    }
    if (options.style == "colour") return io::colour_by_height(z, mask_of(raster), cell, picture);
    if (options.style == "wire" || options.style == "surface") {
        const int lines = options.style == "wire" ? 60 : 0;
        if (is_parametric(raster)) return draw_parametric(raster, width, lines);
        return io::wireframe(z, mask_of(raster), cell, {.width = width, .light = light_of(options)},
                             lines);
    }
    return io::hillshade(z, mask_of(raster), cell, picture);
}

/// Meshes in perspective; the net of a level over the finest surface.
Result<io::Image> draw_polygons(const Render& options) {
    const bool relief_file = io::recognise(options.in) == io::FileKind::Relief;
    const bool net_only = options.level && options.style != "wire";
    RELIEF_TRY(const PolygonMesh mesh, read_polygons(options.in, net_only ? *options.level : 0));
    io::MeshPictureOptions picture;
    picture.width = options.width > 0 ? options.width : 1200;
    picture.up = options.up == "y" ? io::UpAxis::Y : io::UpAxis::Z;
    if (options.viewer) picture.azimuth = *options.viewer;
    PolygonMesh net;
    std::vector<double> distances;
    if (options.style == "wire" && relief_file && options.level) {
        RELIEF_TRY(net, read_polygons(options.in, *options.level));
        picture.net = &net;
    } else if (options.style == "wire") {
        picture.edges.width = 1;
    }
    if (options.style == "error") {
        if (options.reference.empty())
            return Error{ErrorCode::InvalidArgument, "--style error needs --reference FILE", ""};
        RELIEF_TRY(const PolygonMesh reference, read_polygons(options.reference));
        const mesh::TriangleTree tree(mesh::fan_triangles(reference));
        if (tree.empty())
            return Error{ErrorCode::BadInput, "has no faces to measure from", options.reference};
        distances = mesh::vertex_distances(mesh, tree);
        if (options.of_diagonal) {
            const double diagonal = diagonal_of(reference);
            for (double& distance : distances) distance /= diagonal;
            picture.unit = "d";
        }
        picture.values = distances;
        picture.scale = options.scale.value_or(0);
    }
    return io::draw_mesh(mesh, picture);
}

Outcome picture_outcome(const std::string& out, const io::Image& image) {
    Outcome outcome;
    outcome.json = Json{{"width", image.width}, {"height", image.height}};
    outcome.text = fmt::format("{}: {} x {} pixels\n", out, image.width, image.height);
    return outcome;
}

Result<Outcome> run_mesh(const Render& options) {
    if (!options.drape.empty())
        return Error{ErrorCode::InvalidArgument, "--drape is for rasters", ""};
    auto image = draw_polygons(options);
    if (!image.ok()) return image.error();
    if (!options.caption.empty()) image = io::with_caption(*image, options.caption);
    RELIEF_CHECK(io::write_png(options.out, *image));
    return picture_outcome(options.out, *image);
}

/// Seen from above as a raster of the picture's width, or in perspective with triangles.
Result<Outcome> run_ps(const Render& options, const Globals& globals) {
    const int width = options.width > 0 ? options.width : 1200;
    io::Image image;
    if (options.style == "wire") {
        RELIEF_TRY(image, draw_ps(options.in,
                                  {width, options.exaggeration, options.viewer, options.level}));
    } else {
        RELIEF_TRY(const Raster raster,
                   picture_raster(options.in, options.level.value_or(0), width));
        RELIEF_TRY(image, draw(options, raster, globals));
    }
    if (!options.caption.empty()) image = io::with_caption(image, options.caption);
    RELIEF_CHECK(io::write_png(options.out, image));
    return picture_outcome(options.out, image);
}

Result<Outcome> run(const Render& options, const Globals& globals) {
    if (is_mesh(options.in)) return run_mesh(options);
    if (options.of_diagonal)
        return Error{ErrorCode::InvalidArgument, "a --scale in diagonals (1e-3d) is for meshes",
                     ""};
    if (holds_ps(options.in)) return run_ps(options, globals);
    io::Image image;
    const bool relief_file = io::recognise(options.in) == io::FileKind::Relief;
    if (options.level && !relief_file)
        return Error{ErrorCode::InvalidArgument, "--level needs a .relief file", ""};
    if (options.level) {
        RELIEF_TRY(const codec::RasterFile file, open_relief(options.in));
        if (*options.level > file.layout().levels()) return file.decode(*options.level).error();
        RELIEF_TRY(const Raster raster, level_surface(file, *options.level));
        if (options.style == "wire" && !is_parametric(raster)) {
            RELIEF_TRY(const auto net, file.coefficients(*options.level));
            image = draw_net(options, raster, net, *options.level, file.margin());
        } else {
            RELIEF_TRY(image, draw(options, raster, globals));
        }
    } else {
        RELIEF_TRY(const Raster raster, read_any_raster(options.in, globals));
        RELIEF_TRY(image, draw(options, raster, globals));
    }
    if (!options.caption.empty()) image = io::with_caption(image, options.caption);
    RELIEF_CHECK(io::write_png(options.out, image));
    return picture_outcome(options.out, image);
}

}  // namespace

void add_render(Program& program) {
    auto options = std::make_shared<Render>();
    CLI::App* verb =
        add_verb(program, "render",
                 "Draw a raster, a mesh or a .relief file as a PNG picture, without a screen.",
                 "  relief render dem.relief hills.png --width 1200\n"
                 "  relief render dem.relief error.png --style error --reference dem.tif\n"
                 "  relief render dem.relief net.png --style wire --level 4\n"
                 "  relief render model.obj model.png --up y",
                 [options, &program] { return run(*options, program.globals); });
    verb->add_option("IN", options->in,
                     "a raster or a .relief file; three bands are drawn as a surface in space by "
                     "wire and surface")
        ->required();
    verb->add_option("OUT", options->out, "the .png file")->required();
    verb->add_option("--width", options->width,
                     "pixels across, error at least 180; default: the raster's columns, at least "
                     "800")
        ->check(CLI::Range(16, 16384));
    verb->add_option(
            "--style", options->style,
            "seen from above: hillshade (default), colour, error; in perspective: surface, wire")
        ->check(CLI::IsMember({"hillshade", "colour", "error", "surface", "wire"}));
    verb->add_option("--reference", options->reference,
                     "what the error is measured against (error)");
    verb->add_option("--drape", options->drape,
                     "a PNG laid over the ground, stretched to the raster's extent");
    verb->add_option(
        "--level", options->level,
        "draw the surface of this level of a .relief file; with wire its control net too, for "
        "splines on triangles its control triangles");
    add_length(*verb, "--scale", options->scale, options->of_diagonal,
               "difference at the ends of the colours (error), for meshes with a d in diagonals of "
               "the reference (1e-3d); default: the largest");
    verb->add_option("--exaggeration", options->exaggeration,
                     "vertical factor; default: from the mean slope");
    verb->add_option("--azimuth", options->azimuth,
                     "of the light, degrees clockwise from north (default 315)");
    verb->add_option("--altitude", options->altitude,
                     "of the light, degrees above the horizon (default 45)");
    verb->add_flag("--multidirectional", options->multidirectional, "four lights instead of one");
    verb->add_option("--up", options->up, "meshes: the axis that points up, z (default) or y")
        ->check(CLI::IsMember({"y", "z"}));
    verb->add_option("--viewer", options->viewer,
                     "meshes: where the viewer stands, degrees clockwise from north (default 215)");
    verb->add_option("--caption", options->caption,
                     "a line of text below the picture: lower-case letters, digits, + - . , : / %");
}

}  // namespace relief::cli
