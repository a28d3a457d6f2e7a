#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "mesh_verbs.h"
#include "ps_verbs.h"
#include "relief/io/file_kind.h"
#include "relief/io/mesh.h"
#include "relief/io/raster.h"
#include "relief/io/vtk.h"

namespace relief::cli {

namespace ps = multires::ps;
using mesh::Index;

namespace {

/// Samples that are evaluated and written at a time.
constexpr std::int64_t kStrip = std::int64_t{1} << 22;

struct Extent {
    Vec2 low;
    Vec2 high;
};

Extent extent_of(const codec::PsFile& file) {
    const auto [x0, y0, x1, y1] = file.extent();
    return {{x0, y0}, {x1, y1}};
}

/// Cells of a raster over the plane, row 0 north.
struct Frame {
    Vec2 corner;  ///< of the first cell, outside: west and north
    double cell = 1;
    LatticeBox box;

    [[nodiscard]] ps::RasterFrame samples() const {
        return {{corner.x + (static_cast<double>(box.col0) + 0.5) * cell,
                 corner.y - (static_cast<double>(box.row0) + 0.5) * cell},
                {cell, -cell}};
    }
    [[nodiscard]] GeoReference geo() const {
        GeoReference geo;
        geo.transform = {corner.x + static_cast<double>(box.col0) * cell, cell, 0,
                         corner.y - static_cast<double>(box.row0) * cell, 0,    -cell};
        return geo;
    }
};

/// The largest of 1, 2 and 5 times a power of ten that is not larger.
double round_down(double value) {
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    const double digit = value / power;
    return (digit >= 5 ? 5 : digit >= 2 ? 2 : 1) * power;
}

/// About one cell for each vertex.
double default_cell(const Extent& extent, std::uint64_t vertices) {
    const Vec2 size = extent.high - extent.low;
    return round_down(std::sqrt(size.x * size.y / static_cast<double>(vertices)));
}

/// Cell boundaries are multiples of the cell size, so that rasters of neighbouring areas fit.
Result<Frame> aligned_frame(const Extent& extent, double cell) {
    const double west = std::floor(extent.low.x / cell);
    const double east = std::ceil(extent.high.x / cell);
    const double south = std::floor(extent.low.y / cell);
    const double north = std::ceil(extent.high.y / cell);
    const double cols = std::max(1.0, east - west);
    const double rows = std::max(1.0, north - south);
    if (!(cols <= INT32_MAX && rows <= INT32_MAX))
        return Error{
            ErrorCode::InvalidArgument,
            fmt::format("cells of {} make the raster too large; give a larger --cell", shown(cell)),
            ""};
    return Frame{{west * cell, north * cell},
                 cell,
                 {0, 0, static_cast<std::int64_t>(rows), static_cast<std::int64_t>(cols)}};
}

Result<Frame> window_of(Frame frame, const std::vector<std::int64_t>& window) {
    if (window.empty()) return frame;
    const LatticeBox box{window[1], window[0], window[3], window[2]};
    const LatticeBox& all = frame.box;
    if (box.rows < 1 || box.cols < 1 || box.row0 < 0 || box.col0 < 0 ||
        box.row0 > all.rows - box.rows || box.col0 > all.cols - box.cols)
        return Error{ErrorCode::InvalidArgument,
                     fmt::format("the window {},{},{},{} is not inside the {} x {} raster",
                                 box.col0, box.row0, box.cols, box.rows, all.cols, all.rows),
                     ""};
    frame.box = box;
    return frame;
}

/// A surface that becomes a raster, and what its numbers are.
struct Sampled {
    const ps::Surface& surface;
    const codec::PsReference& reference;
};

Raster description_of(const Frame& frame, const codec::PsReference& reference) {
    Raster raster;
    raster.rows = frame.box.rows;
    raster.cols = frame.box.cols;
    raster.type = SampleType::Float64;
    raster.geo = frame.geo();
    raster.geo.crs = reference.crs;
    raster.unit = reference.unit;
    return raster;
}

Result<Raster> sample(const Sampled& source, const Frame& frame) {
    const ps::Surface& surface = source.surface;
    Raster raster = description_of(frame, source.reference);
    raster.mask = Grid<std::uint8_t>(raster.rows, raster.cols);
    for (int c = 0; c < surface.components(); ++c) {
        Grid<double> plane(raster.rows, raster.cols);
        RELIEF_CHECK(ps::evaluate_raster(surface, frame.samples(), plane.view(), c));
        raster.planes.push_back(std::move(plane));
    }
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            raster.mask(r, c) = !std::isnan(raster.planes[0](r, c));
    return raster;
}

Status write_samples(const Sampled& source, const Frame& frame, const std::string& path,
                     const Globals& globals) {
    const Progress progress = progress_bar(globals, "decoding");
    RELIEF_TRY(auto writer,
               io::RasterWriter::create(path, description_of(frame, source.reference),
                                        source.surface.components(), io::Holes::Possible));
    const LatticeBox& box = frame.box;
    const std::int64_t height = std::max<std::int64_t>(1, kStrip / box.cols);
    for (std::int64_t row = 0; row < box.rows; row += height) {
        Frame strip = frame;
        strip.box.row0 += row;
        strip.box.rows = std::min(height, box.rows - row);
        RELIEF_TRY(const Raster samples, sample(source, strip));
        RELIEF_CHECK(writer.write(row, samples));
        if (!progress(static_cast<double>(row + strip.box.rows) / static_cast<double>(box.rows)))
            return Error{ErrorCode::Cancelled, "decoding was cancelled", path};
    }
    return writer.commit();
}

Status write_table(const codec::PsFile& file, const PsLevel& level, const std::string& path) {
    RELIEF_TRY(const auto components, codec::tangent_planes_of(file, *level.data));
    const mesh::Triangulation& mesh = level.space().mesh;
    std::vector<std::vector<double>> columns(2 + 3 * components.size());
    std::vector<std::string> names{"x", "y"};
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        columns[0].push_back(mesh.origin.x + mesh.x[v]);
        columns[1].push_back(mesh.origin.y + mesh.y[v]);
    }
    for (std::size_t m = 0; m < components.size(); ++m) {
        const std::string suffix = components.size() > 1 ? std::to_string(m + 1) : "";
        for (const char* name : {"value", "dx", "dy"}) names.push_back(name + suffix);
        for (const spline::TangentPlane& plane : components[m]) {
            columns[2 + 3 * m].push_back(plane.value);
            columns[3 + 3 * m].push_back(plane.gradient.x);
            columns[4 + 3 * m].push_back(plane.gradient.y);
        }
    }
    std::vector<io::CsvColumn> table;
    for (std::size_t k = 0; k < columns.size(); ++k) table.push_back({names[k], columns[k]});
    return io::write_csv(path, table);
}

Status write_raster_of(const codec::PsFile& file, const PsLevel& level, const PsDecodeVerb& verb,
                       const Globals& globals, Outcome& outcome) {
    const Extent extent = extent_of(file);
    const double cell =
        verb.cell.value_or(default_cell(extent, file.counts(0).vertices)) / verb.scale;
    RELIEF_TRY(const Frame all, aligned_frame(extent, cell));
    RELIEF_TRY(const Frame frame, window_of(all, verb.window));
    RELIEF_CHECK(write_samples({level.surface, file.reference()}, frame, verb.out, globals));
    outcome.json["samples"] = frame.box.count();
    outcome.json["rows"] = frame.box.rows;
    outcome.json["cols"] = frame.box.cols;
    outcome.json["cell"] = cell;
    outcome.text = fmt::format("{}: {} x {} samples of level {}, cells of {}\n", verb.out,
                               frame.box.cols, frame.box.rows, verb.level, shown(cell));
    return {};
}

Status write_triangles(const codec::PsFile& file, const PsLevel& level, const PsDecodeVerb& verb,
                       const std::string& extension, Outcome& outcome) {
    const mesh::Triangulation& mesh = level.space().mesh;
    std::vector<std::string> missing;
    if (extension == ".csv") {
        RELIEF_CHECK(write_table(file, level, verb.out));
    } else if (extension == ".vtu") {
        RELIEF_CHECK(write_bezier(level, verb.out));
    } else {
        RELIEF_TRY(const PolygonMesh polygons, codec::polygons_of(file, *level.data));
        RELIEF_TRY(missing, io::write_mesh(verb.out, polygons,
                                           {.up = file.components() == 1 ? io::Up::Z : io::Up::Y}));
    }
    outcome.json["samples"] = mesh.vertex_count();
    outcome.text =
        fmt::format("{}: {} vertices and {} triangles of level {}\n", verb.out,
                    grouped(mesh.vertex_count()), grouped(mesh.triangle_count()), verb.level) +
        left_out(missing);
    return {};
}

}  // namespace

Result<Outcome> decode_ps(const PsDecodeVerb& verb, const Globals& globals) {
    const Stopwatch watch;
    std::string extension = std::filesystem::path(verb.out).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool triangles = extension == ".csv" || extension == ".vtu" || io::names_mesh(verb.out);
    if (triangles && (verb.cell || verb.scale != 1 || !verb.window.empty()))
        return Error{ErrorCode::InvalidArgument, "--cell, --scale and --window are for rasters",
                     verb.out};
    if (verb.cell && !(*verb.cell > 0 && std::isfinite(*verb.cell)))
        return Error{ErrorCode::InvalidArgument, "--cell must be a positive number", ""};
    RELIEF_TRY(const codec::PsFile file, open_ps(verb.in, verb.max_bytes));
    const auto level = open_level(file, verb.level);
    if (!level.ok()) return located(level.error(), verb.in);
    const std::optional<double> bound = file.bound(verb.level);
    Outcome outcome;
    outcome.json = Json{{"samples", 0},
                        {"bytes_read", file.bytes_for(verb.level)},
                        {"level", verb.level},
                        {"bound", json_number(bound)},
                        {"surface_bound", json_number(file.surface_bound(verb.level))},
                        {"vertices", level->space().mesh.vertex_count()},
                        {"triangles", level->space().mesh.triangle_count()},
                        {"finest_level", file.finest_level()}};
    RELIEF_CHECK(triangles ? write_triangles(file, *level, verb, extension, outcome)
                           : write_raster_of(file, *level, verb, globals, outcome));
    if (bound) outcome.text += fmt::format("within {} of what was encoded\n", shown(*bound));
    outcome.json["seconds"] = watch.seconds();
    return outcome;
}

Result<Raster> picture_raster(const std::string& path, int level, int columns) {
    RELIEF_TRY(const codec::PsFile file, open_ps(path));
    const auto opened = open_level(file, level);
    if (!opened.ok()) return located(opened.error(), path);
    const Extent extent = extent_of(file);
    const Vec2 size = extent.high - extent.low;
    const double cell = std::max(size.x, size.y / 4) / columns;
    const auto cells = [cell](double length) {
        return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(length / cell)));
    };
    return sample({opened->surface, file.reference()},
                  {{extent.low.x, extent.high.y}, cell, {0, 0, cells(size.y), cells(size.x)}});
}

}  // namespace relief::cli
