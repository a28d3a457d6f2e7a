#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
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

Result<io::PointColumns> columns_of(const std::string& text) {
    io::PointColumns columns;
    if (text.empty()) return columns;
    std::vector<std::string> names;
    std::istringstream fields(text);
    for (std::string name; std::getline(fields, name, ',');) names.push_back(name);
    const bool empty =
        std::any_of(names.begin(), names.end(), [](const auto& n) { return n.empty(); });
    if (names.size() < 3 || names.size() > 4 || empty || text.back() == ',')
        return Error{ErrorCode::InvalidArgument,
                     "--columns takes X,Y,VALUE[,WEIGHT], not '" + text + "'", ""};
    columns.x = names[0];
    columns.y = names[1];
    columns.value = names[2];
    if (names.size() == 4) columns.weight = names[3];
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
    const auto [least, most] = std::minmax_element(points.values.begin(), points.values.end());
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

namespace {

/// The number before a colon and the one to three after it.
Result<codec::PsMove> parse_move(const std::string& text, int level) {
    const Error wrong{ErrorCode::InvalidArgument,
                      "--move of a spline on triangles takes INDEX:DZ[,DX,DY], not '" + text + "'",
                      ""};
    const char* const end = text.data() + text.size();
    codec::PsMove move;
    move.level = level;
    auto [at, error] = std::from_chars(text.data(), end, move.vertex);
    if (error != std::errc() || at == end || *at != ':') return wrong;
    std::array<double, 3> numbers{};
    std::size_t count = 0;
    do {
        if (count == numbers.size()) return wrong;
        const auto number = std::from_chars(at + 1, end, numbers[count++]);
        if (number.ec != std::errc()) return wrong;
        at = number.ptr;
    } while (at != end && *at == ',');
    if (at != end || count == 2) return wrong;
    move.rise = numbers[0];
    move.tilt = {numbers[1], numbers[2]};
    return move;
}

}  // namespace

Result<Outcome> edit_ps(const std::string& in, const std::string& out, int level,
                        const std::vector<std::string>& texts) {
    std::vector<codec::PsMove> moves;
    for (const std::string& text : texts) {
        RELIEF_TRY(const codec::PsMove move, parse_move(text, level));
        moves.push_back(move);
    }
    if (moves.empty())
        return Error{ErrorCode::InvalidArgument,
                     "nothing to do; give --level K --move INDEX:DZ[,DX,DY]", ""};
    RELIEF_TRY(Bytes bytes, io::read_file(in));
    const auto edited = codec::add_ps_moves(std::move(bytes), moves);
    if (!edited.ok()) return located(edited.error(), in);
    return write_edited_ps(in, out, *edited);
}

Result<Outcome> write_edited_ps(const std::string& in, const std::string& out,
                                const Bytes& edited) {
    const auto after_file = codec::PsFile::open(edited);
    if (!after_file.ok()) return located(after_file.error(), in);
    RELIEF_TRY(const codec::PsFile before_file, open_ps(in));
    const auto before = before_file.surface(0);
    if (!before.ok()) return located(before.error(), in);
    const auto after = after_file->surface(0);
    if (!after.ok()) return located(after.error(), in);
    RELIEF_CHECK(io::write_file_atomically(out, edited));
    const std::size_t moved = after_file->moves().size() - before_file.moves().size();

    const mesh::Triangulation& mesh = after->space.mesh;
    std::int64_t touched = 0;
    Vec2 low{INFINITY, INFINITY};
    Vec2 high{-INFINITY, -INFINITY};
    for (mesh::Index v = 0; v < mesh.vertex_count(); ++v) {
        const auto same = [&](std::size_t m) {
            return before->components[m][v] == after->components[m][v];
        };
        bool differs = false;
        for (std::size_t m = 0; m < after->components.size(); ++m) differs |= !same(m);
        if (!differs) continue;
        ++touched;
        const Vec2 place = mesh.origin + mesh.vertex(v);
        low = {std::min(low.x, place.x), std::min(low.y, place.y)};
        high = {std::max(high.x, place.x), std::max(high.y, place.y)};
    }
    Outcome outcome;
    outcome.json =
        Json{{"moved", moved},
             {"touched", touched},
             {"bounds", touched == 0 ? Json(nullptr) : Json::array({low.x, low.y, high.x, high.y})},
             {"edits", after_file->moves().size()},
             {"bytes", edited.size()}};
    outcome.text = fmt::format("{}: {} control triangles moved, {} of level 0 touched\n", out,
                               moved, grouped(touched));
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
