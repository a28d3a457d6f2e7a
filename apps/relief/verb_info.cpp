#include <fmt/format.h>

#include <algorithm>

#include "command.h"
#include "level_files.h"
#include "mesh_verbs.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"
#include "relief/io/raster.h"

namespace relief::cli {

namespace {

Json extent_of(const GeoReference& geo, std::int64_t rows, std::int64_t cols) {
    if (!geo.transform) return nullptr;
    const auto& t = *geo.transform;
    double low[2] = {INFINITY, INFINITY};
    double high[2] = {-INFINITY, -INFINITY};
    for (const double r : {0.0, static_cast<double>(rows)})
        for (const double c : {0.0, static_cast<double>(cols)}) {
            const double place[2] = {t[0] + t[1] * c + t[2] * r, t[3] + t[4] * c + t[5] * r};
            for (int k = 0; k < 2; ++k) {
                low[k] = std::min(low[k], place[k]);
                high[k] = std::max(high[k], place[k]);
            }
        }
    return Json::array({low[0], low[1], high[0], high[1]});
}

Json band_json(const codec::BandInfo& band) {
    return Json{{"name", band.layout.name},
                {"level", band.layout.level},
                {"rows", band.layout.box.rows},
                {"cols", band.layout.box.cols},
                {"origin", Json::array({band.layout.box.row0, band.layout.box.col0})},
                {"norm", band.layout.norm_samples},
                {"step", band.step}};
}

Result<Outcome> info_of_relief(const std::string& path) {
    RELIEF_TRY(const codec::RasterFile file, open_relief(path));
    const auto& layout = file.layout();
    const Raster& about = file.description();
    Outcome outcome;
    Json bands = Json::array();
    for (const auto& band : file.bands()) bands.push_back(band_json(band));
    Json levels = Json::array();
    for (int level = 0; level <= layout.levels(); ++level) {
        const LatticeBox box = multires::scaling_box(layout, level);
        levels.push_back(Json{{"level", level},
                              {"control_rows", box.rows},
                              {"control_cols", box.cols},
                              {"control_origin", Json::array({box.row0, box.col0})},
                              {"bytes", file.bytes_for(level)},
                              {"bound", json_number(file.bound(level))},
                              {"surface_bound", json_number(file.surface_bound(level))}});
    }
    const auto bound = file.bound(0);
    const bool sound = file.checksums_ok();
    outcome.json = Json{{"format", "relief"},
                        {"version", file.version()},
                        {"scheme", multires::scheme_name(file.spec().id)},
                        {"order", file.spec().order},
                        {"levels", layout.levels()},
                        {"profile", file.closed_loop() ? Json(file.profile()) : Json(nullptr)},
                        {"rows", layout.rows},
                        {"cols", layout.cols},
                        {"components", layout.components},
                        {"type", sample_type_name(about.type)},
                        {"nodata", about.nodata ? json_number(*about.nodata) : Json(nullptr)},
                        {"unit", about.unit},
                        {"bands", bands},
                        {"level_list", levels},
                        {"chunks", chunks_json(file)},
                        {"bytes", file.size()},
                        {"max_error", json_number(file.max_error())},
                        {"rms_error", json_number(file.rms_error())},
                        {"bound", json_number(bound)},
                        {"edits", file.moves().size()},
                        {"crs", about.geo.crs},
                        {"extent", extent_of(about.geo, layout.rows, layout.cols)},
                        {"checksums_ok", sound}};
    outcome.text = head_text(path, file, sound);
    outcome.text +=
        fmt::format("raster {} x {}, {} component{}, {}{}\n", layout.cols, layout.rows,
                    layout.components, layout.components == 1 ? "" : "s",
                    sample_type_name(about.type), about.unit.empty() ? "" : " in " + about.unit);
    outcome.text +=
        fmt::format("scheme {} order {}, {} levels", multires::scheme_name(file.spec().id),
                    file.spec().order, layout.levels());
    outcome.text += bound ? fmt::format(", within {} of the original (rms {})\n", shown(*bound),
                                        shown(file.rms_error()))
                          : ", " + edits_text(file.moves().size()) + '\n';
    outcome.text += "level   control net      bytes to read   error at most\n";
    for (const Json& level : levels)
        outcome.text += fmt::format(
            "{:5}   {:>5} x {:<7} {:>14}   {}\n", level["level"].get<int>(),
            level["control_cols"].get<std::int64_t>(), level["control_rows"].get<std::int64_t>(),
            grouped(level["bytes"].get<std::int64_t>()),
            level["surface_bound"].is_null() ? "-" : shown(level["surface_bound"].get<double>()));
    return outcome;
}

Result<Outcome> info_of_raster(const std::string& path, const Globals& globals) {
    RELIEF_TRY(const Raster raster, read_any_raster(path, globals));
    Json bands = Json::array();
    std::string text = fmt::format(
        "{}: raster {} x {}, {}{}, {} of {} samples valid\n", path, raster.cols, raster.rows,
        sample_type_name(raster.type), raster.unit.empty() ? "" : " in " + raster.unit,
        grouped(raster.valid_count()), grouped(raster.rows * raster.cols));
    for (std::size_t p = 0; p < raster.planes.size(); ++p) {
        double low = INFINITY;
        double high = -INFINITY;
        for (std::int64_t r = 0; r < raster.rows; ++r)
            for (std::int64_t c = 0; c < raster.cols; ++c)
                if (raster.valid(r, c)) {
                    low = std::min(low, raster.planes[p](r, c));
                    high = std::max(high, raster.planes[p](r, c));
                }
        const std::string name = p < raster.band_names.size() ? raster.band_names[p] : "";
        bands.push_back(
            Json{{"name", name}, {"min", json_number(low)}, {"max", json_number(high)}});
        text += fmt::format("band {}{}: {} .. {}\n", p + 1, name.empty() ? "" : " " + name,
                            shown(low), shown(high));
    }
    std::error_code ignored;
    Outcome outcome;
    outcome.json = Json{{"format", "raster"},
                        {"version", nullptr},
                        {"scheme", nullptr},
                        {"order", nullptr},
                        {"levels", 0},
                        {"rows", raster.rows},
                        {"cols", raster.cols},
                        {"type", sample_type_name(raster.type)},
                        {"nodata", raster.nodata ? json_number(*raster.nodata) : Json(nullptr)},
                        {"unit", raster.unit},
                        {"valid", raster.valid_count()},
                        {"bands", bands},
                        {"bytes", std::filesystem::file_size(path, ignored)},
                        {"bound", nullptr},
                        {"crs", raster.geo.crs},
                        {"extent", extent_of(raster.geo, raster.rows, raster.cols)},
                        {"checksums_ok", nullptr}};
    outcome.text = text;
    return outcome;
}

}  // namespace

void add_info(Program& program) {
    auto path = std::make_shared<std::string>();
    CLI::App* verb = add_verb(
        program, "info", "Say what is in a file, level by level, and whether its checksums hold.",
        "  relief info dem.relief\n  relief info dem.tif --json",
        [path, &program]() -> Result<Outcome> {
            const io::FileKind kind = io::recognise(*path);
            if (kind == io::FileKind::Mesh) return info_of_mesh(*path);
            if (kind == io::FileKind::Points) return info_of_points(*path);
            if (holds_ps(*path)) return info_of_ps(*path);
            if (holds_quads(*path)) return info_of_quads(*path);
            if (holds_mesh(*path)) return info_of_mesh_file(*path);
            if (kind == io::FileKind::Relief) return info_of_relief(*path);
            return info_of_raster(*path, program.globals);
        });
    verb->add_option("IN", *path, "a .relief file, a raster, a mesh or points")->required();
}

}  // namespace relief::cli
