#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <sstream>

#include "level_files.h"
#include "ps_verbs.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"
#include "relief/mesh/triangle_locator.h"

namespace relief::cli {

namespace ps = multires::ps;

namespace {

constexpr std::string_view kContent = "powell-sabin";

constexpr FaceCount<codec::PsCounts> kTriangles = {"triangles", &codec::PsCounts::triangles};

std::string text_of(const codec::PsFile& file, const std::string& path, const Json& levels,
                    bool sound) {
    const auto [low_x, low_y, high_x, high_y] = file.extent();
    const auto& [crs, unit_name] = file.reference();
    const std::string unit = unit_name.empty() ? "" : " " + unit_name;
    std::string text = head_text(path, file, sound);
    text += fmt::format(
        "scheme powell-sabin on {} vertices and {} triangles{}, {} levels, {}\n"
        "x {} .. {}, y {} .. {}{}\n",
        grouped(static_cast<std::int64_t>(file.counts(0).vertices)),
        grouped(static_cast<std::int64_t>(file.counts(0).triangles)),
        file.delaunay() ? " (Delaunay)" : "", file.levels(),
        file.holds_values() ? "values at vertices" : "coefficients", shown(low_x), shown(high_x),
        shown(low_y), shown(high_y), crs.empty() ? "" : ", " + crs);
    text += file.edited() ? edits_text(file.moves().size()) + '\n'
                          : fmt::format("max error {}{}, rms error {}{}\n", shown(file.max_error()),
                                        unit, shown(file.rms_error()), unit);
    text += levels_text(levels, kTriangles.name);
    return text;
}

}  // namespace

bool holds_ps(const std::string& path) {
    return holds(path, kContent);
}

bool is_points(const std::string& path) {
    return io::recognise(path) == io::FileKind::Points;
}

Result<codec::PsFile> open_ps(const std::string& path, std::optional<std::uint64_t> max_bytes) {
    return open_file<codec::PsFile>(path, max_bytes);
}

Result<PsLevel> open_level(const codec::PsFile& file, int level) {
    RELIEF_TRY(codec::PsSurface data, file.surface(level));
    auto owned = std::make_unique<const codec::PsSurface>(std::move(data));
    RELIEF_TRY(ps::Surface surface, ps::Surface::create(owned->space, owned->components));
    return PsLevel{std::move(owned), std::move(surface)};
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
    const Json levels = levels_json(file, kTriangles);
    const bool sound = file.checksums_ok();
    const char* const kind = file.holds_values() ? "values" : "coefficients";
    const Json more{{"vertices", file.counts(0).vertices}, {"triangles", file.counts(0).triangles},
                    {"components", file.components()},     {"kind", kind},
                    {"delaunay", file.delaunay()},         {"lossless", file.lossless()},
                    {"unit", file.reference().unit},       {"crs", file.reference().crs}};
    Outcome outcome;
    outcome.json = info_json(file,
                             {.content = kContent,
                              .scheme = kContent,
                              .order = 2,
                              .more = more,
                              .bands = bands_json(file, [&](int) { return kind; }),
                              .levels = levels},
                             sound);
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

}  // namespace relief::cli
