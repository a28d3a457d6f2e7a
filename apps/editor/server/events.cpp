#include "events.h"

#include <filesystem>

namespace relief::editor {

namespace {

Json levels_json(const edit::Description& about) {
    Json levels = Json::array();
    for (const edit::LevelInfo& level : about.levels) {
        levels.push_back(Json{{"level", levels.size()},
                              {"control_points", level.control_points},
                              {"faces", level.faces},
                              {"bytes", level.bytes}});
        if (about.kind == edit::Kind::Raster)
            levels.back().update(Json{{"rows", level.rows}, {"cols", level.cols}});
    }
    return levels;
}

Json tiles_json(const edit::TileInfo& tiles) {
    return {{"rows", tiles.rows},
            {"cols", tiles.cols},
            {"tile", tiles.tile},
            {"coarsest", tiles.coarsest},
            {"spacing", tiles.spacing}};
}

Json history_json(const edit::History& history) {
    Json entries = Json::array();
    for (const edit::HistoryEntry& entry : history.entries)
        entries.push_back(Json{{"text", entry.text}});
    return {{"done", history.done}, {"entries", std::move(entries)}};
}

/// What differs from one revision to the next.
Json state_json(const edit::Session& session) {
    const edit::Bounds bounds = session.bounds();
    return {{"revision", session.revision()},
            {"history", history_json(session.history())},
            {"min", json_of(bounds.min)},
            {"max", json_of(bounds.max)}};
}

}  // namespace

Json json_of(const Vec3<double>& point) {
    return Json::array({point.x, point.y, point.z});
}

Json hello_event(const Document& document, const edit::Session& session, bool writer) {
    const edit::Description& about = session.description();
    Json hello = state_json(session);
    hello.update(Json{{"event", "hello"},
                      {"protocol", 1},
                      {"version", RELIEF_VERSION},
                      {"name", document.name},
                      {"kind", edit::kind_name(about.kind)},
                      {"writer", writer},
                      {"levels", levels_json(about)},
                      {"scheme", about.scheme},
                      {"order", about.order},
                      {"components", about.components},
                      {"parametric", about.parametric},
                      {"origin", json_of(about.origin)},
                      {"unit", about.unit},
                      {"crs", about.crs},
                      {"bound", about.bound ? Json(*about.bound) : Json(nullptr)},
                      {"bytes", about.bytes},
                      {"save", std::filesystem::path(document.save).filename().string()}});
    if (about.tiles) hello["raster"] = tiles_json(*about.tiles);
    return hello;
}

Json changed_event(const edit::Session& session, std::uint64_t touched,
                   std::optional<std::uint64_t> cause) {
    Json changed = state_json(session);
    changed.update(Json{{"event", "changed"},
                        {"touched", touched},
                        {"cause", cause ? Json(*cause) : Json(nullptr)}});
    return changed;
}

Json progress_event(std::uint64_t id, double fraction) {
    return {{"event", "progress"}, {"id", id}, {"fraction", fraction}};
}

Json notice_event(const std::string& message) {
    return {{"event", "notice"}, {"message", message}};
}

Json closing_event() {
    return {{"event", "closing"}};
}

}  // namespace relief::editor
