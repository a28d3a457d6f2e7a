#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <sstream>

#include "ps_verbs.h"
#include "relief/codec/quad_codec.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"
#include "relief/mesh/triangle_locator.h"

namespace relief::cli {

namespace ps = multires::ps;

namespace {

constexpr std::string_view kContent = "powell-sabin";

Json levels_json(const codec::PsFile& file) {
    Json levels = Json::array();
    for (int level = 0; level <= file.levels(); ++level)
        levels.push_back(Json{{"level", level},
                              {"vertices", file.counts(level).vertices},
                              {"triangles", file.counts(level).triangles},
                              {"bytes", file.bytes_for(level)},
                              {"bound", json_number(file.bound(level))},
                              {"surface_bound", json_number(file.surface_bound(level))}});
    return levels;
}

/// The vertices that each level adds.
Json bands_json(const codec::PsFile& file) {
    Json bands = Json::array();
    std::uint64_t coarser = 0;
    for (int level = file.levels(); level >= 0; --level) {
        const std::uint64_t vertices = file.counts(level).vertices;
        bands.push_back(Json{{"name", file.holds_values() ? "values" : "coefficients"},
                             {"level", level},
                             {"vertices", vertices - coarser}});
        coarser = vertices;
    }
    return bands;
}

std::string text_of(const codec::PsFile& file, const std::string& path, const Json& levels,
                    bool sound) {
    const auto [low_x, low_y, high_x, high_y] = file.extent();
    std::string text = fmt::format(
        "{}: relief version {}, {} bytes, checksums {}\n"
        "scheme powell-sabin on {} vertices and {} triangles{}, {} levels, {}\n"
        "x {} .. {}, y {} .. {}\n",
        path, file.version(), grouped(static_cast<std::int64_t>(file.size())),
        sound ? "hold" : "DO NOT HOLD", grouped(static_cast<std::int64_t>(file.counts(0).vertices)),
        grouped(static_cast<std::int64_t>(file.counts(0).triangles)),
        file.delaunay() ? " (Delaunay)" : "", file.levels(),
        file.holds_values() ? "values at vertices" : "coefficients", shown(low_x), shown(high_x),
        shown(low_y), shown(high_y));
    if (file.edited())
        text += fmt::format("edited by {} move{}\n", file.moves().size(),
                            file.moves().size() == 1 ? "" : "s");
    else
        text += fmt::format("max error {}, rms error {}\n", shown(file.max_error()),
                            shown(file.rms_error()));
    text += "level     vertices    triangles      bytes to read   surface within\n";
    for (const Json& level : levels)
        text += fmt::format(
            "{:5} {:>12} {:>12} {:>18}   {}\n", level["level"].get<int>(),
            grouped(level["vertices"].get<std::int64_t>()),
            grouped(level["triangles"].get<std::int64_t>()),
            grouped(level["bytes"].get<std::int64_t>()),
            level["surface_bound"].is_null() ? "-" : shown(level["surface_bound"].get<double>()));
    return text;
}

}  // namespace

bool holds_ps(const std::string& path) {
    if (io::recognise(path) != io::FileKind::Relief) return false;
    const auto source = io::open_source(path);
    if (!source.ok()) return false;
    const auto content = codec::content_of(*source);
    return content.ok() && *content == kContent;
}

bool is_points(const std::string& path) {
    return io::recognise(path) == io::FileKind::Points;
}

Result<codec::PsFile> open_ps(const std::string& path, std::optional<std::uint64_t> max_bytes) {
    RELIEF_TRY(auto source, io::open_source(path));
    auto file = codec::PsFile::open(std::move(source),
                                    max_bytes.value_or(std::numeric_limits<std::uint64_t>::max()));
    if (!file.ok()) return located(file.error(), path);
    return file;
}

Result<PsLevel> open_level(const codec::PsFile& file, int level) {
    RELIEF_TRY(codec::PsSurface data, file.surface(level));
    auto owned = std::make_unique<const codec::PsSurface>(std::move(data));
    RELIEF_TRY(ps::Surface surface, ps::Surface::create(owned->space, owned->components));
    return PsLevel{std::move(owned), std::move(surface)};
}

Status check_in_space(int components) {
    if (components != 2) return {};
    return Error{ErrorCode::Unsupported,
                 "two components are no surface in space; decode them as a raster or .csv", ""};
}

std::array<double, 3> in_space(Vec2 place, std::span<const double> values) {
    if (values.size() == 3) return {values[0], values[1], values[2]};
    return {place.x, place.y, values[0]};
}

Result<io::PointColumns> columns_of(const std::string& text) {
    io::PointColumns columns;
    if (text.empty()) return columns;
    std::vector<std::string> names;
    std::istringstream fields(text);
    for (std::string name; std::getline(fields, name, ',');) names.push_back(name);
    const bool empty =
        std::any_of(names.begin(), names.end(), [](const auto& n) { return n.empty(); });
    if (names.size() < 3 || names.size() > 6 || empty || text.back() == ',')
        return Error{ErrorCode::InvalidArgument,
                     "--columns takes X,Y,VALUE[,WEIGHT] or U,V,X,Y,Z[,WEIGHT], not '" + text + "'",
                     ""};
    const std::ptrdiff_t components = names.size() < 5 ? 1 : 3;
    columns.x = names[0];
    columns.y = names[1];
    columns.values.assign(names.begin() + 2, names.begin() + 2 + components);
    if (std::ssize(names) > 2 + components) columns.weight = names.back();
    return columns;
}

Result<Outcome> info_of_ps(const std::string& path) {
    RELIEF_TRY(const codec::PsFile file, open_ps(path));
    const Json levels = levels_json(file);
    const bool sound = file.checksums_ok();
    Outcome outcome;
    outcome.json = Json{{"format", "relief"},
                        {"content", kContent},
                        {"version", file.version()},
                        {"scheme", kContent},
                        {"order", 2},
                        {"levels", file.levels()},
                        {"vertices", file.counts(0).vertices},
                        {"triangles", file.counts(0).triangles},
                        {"components", file.components()},
                        {"kind", file.holds_values() ? "values" : "coefficients"},
                        {"delaunay", file.delaunay()},
                        {"lossless", file.lossless()},
                        {"bands", bands_json(file)},
                        {"level_list", levels},
                        {"chunks", chunks_json(file)},
                        {"bytes", file.size()},
                        {"max_error", json_number(file.max_error())},
                        {"rms_error", json_number(file.rms_error())},
                        {"bound", json_number(file.bound(0))},
                        {"surface_bound", json_number(file.surface_bound(0))},
                        {"edits", file.moves().size()},
                        {"crs", ""},
                        {"extent", file.extent()},
                        {"checksums_ok", sound}};
    outcome.text = text_of(file, path, levels, sound);
    return outcome;
}

Result<Outcome> info_of_points(const std::string& path) {
    RELIEF_TRY(const io::PointSet points, io::read_points(path));
    const auto [west, east] =
        std::minmax_element(points.places.begin(), points.places.end(),
                            [](const Vec2& a, const Vec2& b) { return a.x < b.x; });
    const auto [south, north] =
        std::minmax_element(points.places.begin(), points.places.end(),
                            [](const Vec2& a, const Vec2& b) { return a.y < b.y; });
    const auto [least, most] =
        std::minmax_element(points.values[0].begin(), points.values[0].end());
    std::error_code ignored;
    Outcome outcome;
    outcome.json = Json{{"format", "points"},
                        {"version", nullptr},
                        {"scheme", nullptr},
                        {"order", nullptr},
                        {"levels", 0},
                        {"points", points.places.size()},
                        {"weights", !points.weights.empty()},
                        {"bands", Json::array()},
                        {"bytes", std::filesystem::file_size(path, ignored)},
                        {"bound", nullptr},
                        {"crs", ""},
                        {"extent", Json::array({west->x, south->y, east->x, north->y})},
                        {"min", *least},
                        {"max", *most},
                        {"checksums_ok", nullptr}};
    outcome.text =
        fmt::format("{}: {} points{}\nx {} .. {}, y {} .. {}, value {} .. {}\n", path,
                    grouped(static_cast<std::int64_t>(points.places.size())),
                    points.weights.empty() ? "" : " with weights", shown(west->x), shown(east->x),
                    shown(south->y), shown(north->y), shown(*least), shown(*most));
    return outcome;
}

Result<PsJets> evaluate_ps(const std::string& path, const std::vector<Vec2>& points) {
    RELIEF_TRY(const codec::PsFile file, open_ps(path));
    const auto level = open_level(file, 0);
    if (!level.ok()) return located(level.error(), path);
    PsJets result;
    result.components = level->surface.components();
    result.jets.resize(points.size() * static_cast<std::size_t>(result.components));
    const mesh::TriangleLocator locator(level->space().mesh);
    if (const Status status =
            ps::evaluate(level->surface, locator, points, result.jets, ps::Outside::Nan);
        !status.ok())
        return located(status.error(), path);
    return result;
}

}  // namespace relief::cli
