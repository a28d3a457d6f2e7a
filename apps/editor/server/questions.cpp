#include <algorithm>
#include <chrono>
#include <utility>

#include "conversation.h"
#include "events.h"
#include "relief/io/file.h"
#include "wire.h"

namespace relief::editor {

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// More tiles are not asked for at once.
constexpr std::size_t kMostTiles = 1024;

Error wrong(const std::string& member, const char* what) {
    return {ErrorCode::InvalidArgument, "\"" + member + "\" " + what, ""};
}

Result<double> number(const Json& body, const char* member) {
    const auto found = body.find(member);
    if (found == body.end() || !found->is_number()) return wrong(member, "is not a number");
    return found->get<double>();
}

Result<int> level_of(const Json& body, const char* member, const edit::Session& session) {
    const auto levels = session.description().levels.size();
    const auto found = body.find(member);
    if (found == body.end() || !found->is_number_unsigned() ||
        found->get<std::uint64_t>() >= levels)
        return wrong(member, "is not a level of this file");
    return found->get<int>();
}

Result<edit::View::Show> show_of(const Json& body) {
    using Show = edit::View::Show;
    const Json show = body.value("show", Json("edited"));
    if (show == "edited") return Show::Edited;
    if (show == "original") return Show::Original;
    if (show == "compressed") return Show::Compressed;
    return wrong("show", "is not one of edited, original, compressed");
}

Result<edit::Extras> extras_of(const Json& body) {
    edit::Extras extras;
    const Json with = body.value("with", Json::array());
    if (!with.is_array()) return wrong("with", "is not a list");
    for (const Json& name : with) {
        if (name != "error" && name != "curvature")
            return wrong("with", "has members other than error and curvature");
        (name == "error" ? extras.error : extras.curvature) = true;
    }
    return extras;
}

/// Whole numbers from 0 on that 62 bits hold.
template <std::size_t N>
Result<std::array<std::int64_t, N>> whole_numbers(const Json& list, const char* member) {
    std::array<std::int64_t, N> numbers{};
    if (!list.is_array() || list.size() != N) return wrong(member, "has a wrong number of members");
    for (std::size_t k = 0; k < N; ++k) {
        if (!list[k].is_number_unsigned() || list[k].get<std::uint64_t>() >> 62 != 0)
            return wrong(member, "has members that are no whole numbers");
        numbers[k] = list[k].get<std::int64_t>();
    }
    return numbers;
}

/// How many tiles of a level of detail cover so many samples.
std::int64_t tile_count(std::int64_t samples, int tile, int lod) {
    const std::int64_t side = static_cast<std::int64_t>(tile) << lod;
    return std::max<std::int64_t>(1, (samples - 2 + side) / side);
}

bool exists(const edit::TileInfo& tiles, const edit::TileName& name) {
    return name.lod <= tiles.coarsest && name.row < tile_count(tiles.rows, tiles.tile, name.lod) &&
           name.col < tile_count(tiles.cols, tiles.tile, name.lod);
}

}  // namespace

Status Conversation::question(PageId page, const Request& request, const Wanted& wanted) {
    const std::string& name = request.name;
    if (name == "view") return view(page, request);
    if (name == "forget") return forget(page, request);
    RELIEF_CHECK(adopt(pages_[page]));
    if (name == "tiles") return tiles(page, request);
    if (name == "net") return net(page, request);
    if (name == "at") return at(page, request);
    if (name == "compress") return compress(page, request, wanted);
    if (name == "errors") return errors(page, request);
    if (name == "save") return save(page, request);
    return Error{ErrorCode::InvalidArgument, "there is no question \"" + name + "\"", ""};
}

Status Conversation::view(PageId page, const Request& request) {
    const Json& body = request.body;
    const bool raster = session_.description().kind == edit::Kind::Raster;
    edit::View view;
    RELIEF_TRY(view.level, level_of(body, "level", session_));
    RELIEF_TRY(view.show, show_of(body));
    RELIEF_TRY(view.extras, extras_of(body));
    Page& state = pages_[page];
    Page wanted{view};
    if (state.view == view) wanted.tiles = state.tiles;
    if (raster) wanted.net = state.net;
    if (!raster && body.value("net", Json(false)) == true) {
        wanted.net.emplace();
        const char* member = body.contains("net_level") ? "net_level" : "level";
        RELIEF_TRY(wanted.net->level, level_of(body, member, session_));
    }
    RELIEF_CHECK(adopt(wanted));
    std::vector<Bytes> geometry;
    if (!raster) {
        RELIEF_TRY(geometry, everything(wanted, {request.id, session_.revision()}));
    }
    state = std::move(wanted);
    const auto& level = session_.description().levels[static_cast<std::size_t>(view.level)];
    say_ok(page, request.id,
           {{"counts", {{"control_points", level.control_points}, {"faces", level.faces}}}});
    for (Bytes& message : geometry) outbox_->send(page, std::move(message));
    return {};
}

Result<std::vector<Bytes>> Conversation::everything(Page& page, const Stamp& stamp) const {
    std::vector<Bytes> messages;
    for (const edit::TileName& name : page.tiles) {
        RELIEF_TRY(const edit::TileGeometry tile, session_.tile(name));
        messages.push_back(tile_message(tile, stamp));
    }
    if (session_.description().kind != edit::Kind::Raster) {
        RELIEF_TRY(const edit::SurfaceGeometry surface, session_.surface());
        messages.push_back(surface_message(surface, stamp));
    }
    if (!page.net) return messages;
    RELIEF_TRY(page.net->sent, session_.net(page.net->level, page.net->window));
    messages.push_back(net_message(page.net->sent, stamp));
    return messages;
}

Result<std::vector<edit::TileName>> Conversation::tile_names(const Json& body) const {
    const auto& tiles = session_.description().tiles;
    const Json list = body.value("tiles", Json());
    if (!list.is_array() || list.size() > kMostTiles)
        return wrong("tiles", "is not a list of at most 1024 tiles");
    if (!tiles && !list.empty()) return wrong("tiles", "are asked for, but only rasters have them");
    std::vector<edit::TileName> names;
    for (const Json& item : list) {
        RELIEF_TRY(const auto place, whole_numbers<3>(item, "tiles"));
        if (place[0] > tiles->coarsest) return wrong("tiles", "has a tile that does not exist");
        const edit::TileName name{static_cast<int>(place[0]), place[1], place[2]};
        if (!exists(*tiles, name)) return wrong("tiles", "has a tile that does not exist");
        names.push_back(name);
    }
    return names;
}

/// Each is sent as soon as it is there: the first ones are what the page needs most.
Status Conversation::tiles(PageId page, const Request& request) {
    RELIEF_TRY(const auto names, tile_names(request.body));
    Page& state = pages_[page];
    if (!state.view) return Error{ErrorCode::InvalidArgument, "ask for a view first", ""};
    say_ok(page, request.id);
    const Stamp stamp{request.id, session_.revision()};
    for (const edit::TileName& name : names) {
        const auto tile = session_.tile(name);
        if (!tile.ok()) {
            say(page, notice_event(tile.error().text()));
            continue;
        }
        state.tiles.insert(name);
        session_.hold(name);
        outbox_->send(page, tile_message(*tile, stamp));
    }
    return {};
}

Status Conversation::forget(PageId page, const Request& request) {
    RELIEF_TRY(const auto names, tile_names(request.body));
    for (const edit::TileName& name : names) {
        pages_[page].tiles.erase(name);
        const bool held = std::any_of(pages_.begin(), pages_.end(), [&](const auto& other) {
            return other.second.tiles.count(name) > 0;
        });
        if (!held) session_.forget(name);
    }
    say_ok(page, request.id);
    return {};
}

Status Conversation::net(PageId page, const Request& request) {
    if (request.body.value("level", Json(0)).is_null()) {
        pages_[page].net.reset();
        say_ok(page, request.id);
        return {};
    }
    Net net;
    RELIEF_TRY(net.level, level_of(request.body, "level", session_));
    if (const auto window = request.body.find("window"); window != request.body.end()) {
        RELIEF_TRY(const auto box, whole_numbers<4>(*window, "window"));
        net.window = LatticeBox{box[0], box[1], box[2], box[3]};
    }
    RELIEF_TRY(net.sent, session_.net(net.level, net.window));
    say_ok(page, request.id);
    outbox_->send(page, net_message(net.sent, {request.id, session_.revision()}));
    pages_[page].net = std::move(net);
    return {};
}

Status Conversation::at(PageId page, const Request& request) {
    RELIEF_TRY(const double x, number(request.body, "x"));
    RELIEF_TRY(const double y, number(request.body, "y"));
    RELIEF_TRY(const auto probe, session_.at({x, y}));
    if (probe) {
        say_ok(page, request.id,
               {{"value", probe->value},
                {"gradient", {probe->gradient.x, probe->gradient.y}},
                {"slope", probe->slope},
                {"x", probe->place.x},
                {"y", probe->place.y}});
    } else {
        say_ok(page, request.id,
               {{"value", nullptr},
                {"gradient", nullptr},
                {"slope", nullptr},
                {"x", nullptr},
                {"y", nullptr}});
    }
    return {};
}

Status Conversation::compress(PageId page, const Request& request, const Wanted& wanted) {
    RELIEF_TRY(const double max_error, number(request.body, "max_error"));
    const Progress progress = [&, said = Clock::now()](double fraction) mutable {
        if (Clock::now() - said > 200ms) {
            said = Clock::now();
            say(page, progress_event(request.id, fraction));
        }
        return wanted();
    };
    RELIEF_TRY(const edit::Compression result, session_.compress(max_error, progress));
    compressed_ = result.file;
    say_ok(page, request.id,
           {{"bytes", result.bytes},
            {"kept", result.kept},
            {"coefficients", result.coefficients},
            {"max_error", result.max_error},
            {"rms_error", result.rms_error}});
    return {};
}

Status Conversation::errors(PageId page, const Request& request) {
    RELIEF_TRY(const edit::Measurement measured, session_.measure());
    say_ok(page, request.id,
           {{"max_error", measured.max_error},
            {"rms_error", measured.rms_error},
            {"place", json_of(measured.place)}});
    return {};
}

Status Conversation::save(PageId page, const Request& request) {
    if (document_.save.empty())
        return Error{ErrorCode::InvalidArgument,
                     "this file has no place to be saved to; download it instead", ""};
    RELIEF_TRY(const Bytes bytes, session_.file());
    RELIEF_CHECK(io::write_file_atomically(document_.save, bytes));
    say_ok(page, request.id, {{"path", document_.save}, {"bytes", bytes.size()}});
    return {};
}

}  // namespace relief::editor
