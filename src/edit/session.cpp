#include "relief/edit/session.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "edit/model.h"
#include "relief/codec/container.h"

namespace relief::edit {

namespace {

using Json = nlohmann::json;

Result<std::unique_ptr<Model>> open_model(const std::shared_ptr<const ByteSource>& file,
                                          const OpenOptions& options) {
    const auto content = codec::content_of(file);
    if (!content.ok()) return content.error();
    if (*content == "mesh") return open_mesh(file);
    if (*content == "quadrangulation") return open_quads(file);
    if (*content == "powell-sabin") return open_triangles(file);
    return open_raster(file, options);
}

/// A count or position in a command; `fallback` if it is not there.
Result<std::size_t> count_of(const Json& command, const char* member,
                             std::optional<std::size_t> fallback) {
    if (!command.contains(member) && fallback) return *fallback;
    const Json item = command.value(member, Json());
    if (!item.is_number_unsigned())
        return wrong(std::string("\"") + member + "\" is not a number of commands");
    return item.get<std::size_t>();
}

}  // namespace

const char* kind_name(Kind kind) {
    switch (kind) {
        case Kind::Raster:
            return "raster";
        case Kind::Mesh:
            return "mesh";
        case Kind::Quads:
            return "quads";
        case Kind::Triangles:
            return "triangles";
    }
    return "";
}

struct Session::State {
    std::unique_ptr<Model> model;
    History history;
    View view;
    std::set<TileName> held;
    std::uint64_t revision = 0;
    bool dragging = false;

    /// Takes a drag back.
    void end_drag() {
        if (dragging) model->pop();
        dragging = false;
    }
    [[nodiscard]] Result<std::vector<PointMove>> group_of(const Move& move) const;
    Status push(const Move& move);
    /// Undoes or redoes until `done` commands are in effect.
    Status step_to(std::size_t done);
    [[nodiscard]] Result<Change> report() {
        ++revision;
        return model->changes(view, {held.begin(), held.end()});
    }
    [[nodiscard]] Status check_level(int level) const {
        const auto levels = static_cast<int>(model->description().levels.size());
        if (level >= 0 && level < levels) return {};
        return wrong("there is no level " + std::to_string(level) + "; levels are 0 (finest) to " +
                     std::to_string(levels - 1));
    }
};

Result<std::vector<PointMove>> Session::State::group_of(const Move& move) const {
    RELIEF_CHECK(check_level(move.level));
    RELIEF_TRY(std::vector<PointMove> group, spread(move, *model->graph(move.level)));
    for (const PointMove& point : group) RELIEF_CHECK(model->check(point));
    return group;
}

Status Session::State::push(const Move& move) {
    RELIEF_TRY(std::vector<PointMove> group, group_of(move));
    return model->push(std::move(group));
}

Status Session::State::step_to(std::size_t done) {
    if (done > history.entries.size())
        return wrong("there are " + std::to_string(history.entries.size()) + " commands, not " +
                     std::to_string(done));
    end_drag();
    for (; history.done > done; --history.done) model->pop();
    for (; history.done < done; ++history.done)
        RELIEF_CHECK(push(history.entries[history.done].move));
    return {};
}

Session::Session(std::unique_ptr<State> state) : state_(std::move(state)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

Result<Session> Session::open(std::shared_ptr<const ByteSource> file, const OpenOptions& options) {
    auto state = std::make_unique<State>();
    RELIEF_TRY(state->model, open_model(file, options));
    return Session(std::move(state));
}

const Description& Session::description() const {
    return state_->model->description();
}
Bounds Session::bounds() const {
    return state_->model->bounds();
}
const History& Session::history() const {
    return state_->history;
}
std::uint64_t Session::revision() const {
    return state_->revision;
}

Status Session::set_view(const View& view) {
    RELIEF_CHECK(state_->check_level(view.level));
    if (!(view == state_->view)) state_->held.clear();
    state_->view = view;
    return {};
}
const View& Session::view() const {
    return state_->view;
}
void Session::hold(const TileName& tile) {
    state_->held.insert(tile);
}
void Session::forget(const TileName& tile) {
    state_->held.erase(tile);
}

Result<SurfaceGeometry> Session::surface() const {
    return state_->model->surface(state_->view);
}
Result<TileGeometry> Session::tile(const TileName& name) const {
    return state_->model->tile(state_->view, name);
}
Result<NetGeometry> Session::net(int level, const std::optional<LatticeBox>& window) const {
    RELIEF_CHECK(state_->check_level(level));
    return state_->model->net(level, window);
}
Result<std::optional<Probe>> Session::at(Vec2 page) const {
    return state_->model->at(state_->view, page);
}

Result<Change> Session::apply(const Move& move) {
    state_->end_drag();
    RELIEF_CHECK(state_->push(move));
    History& history = state_->history;
    history.entries.resize(history.done);
    history.entries.push_back({text_of(move), move});
    ++history.done;
    return state_->report();
}

Result<Change> Session::undo(std::size_t count) {
    const std::size_t done = state_->history.done;
    return go_to(done - std::min(done, count));
}

Result<Change> Session::redo(std::size_t count) {
    const History& history = state_->history;
    return go_to(history.done + std::min(history.entries.size() - history.done, count));
}

Result<Change> Session::go_to(std::size_t done) {
    RELIEF_CHECK(state_->step_to(done));
    return state_->report();
}

Result<Change> Session::drag(const Move& move) {
    state_->end_drag();
    RELIEF_TRY(std::vector<PointMove> group, state_->group_of(move));
    RELIEF_CHECK(state_->model->drag(std::move(group)));
    state_->dragging = true;
    return state_->report();
}

Result<Change> Session::release() {
    state_->end_drag();
    return state_->report();
}

Result<Change> Session::run(const Json& command) {
    const Json kind = command.is_object() ? command.value("do", Json()) : Json();
    if (kind == "undo" || kind == "redo") {
        RELIEF_TRY(const std::size_t count, count_of(command, "count", 1));
        return kind == "undo" ? undo(count) : redo(count);
    }
    if (kind == "goto") {
        RELIEF_TRY(const std::size_t done, count_of(command, "done", {}));
        return go_to(done);
    }
    if (kind == "release") return release();
    if (kind == "drag") {
        Json move = command;
        move["do"] = command.value("of", Json("move"));
        RELIEF_TRY(const Move read, read_move(move));
        return drag(read);
    }
    if (kind == "move" || kind == "tilt") {
        RELIEF_TRY(const Move read, read_move(command));
        return apply(read);
    }
    return wrong("is not a command: \"do\" is none of move, tilt, undo, redo, goto, drag, release");
}

Json Session::script() const {
    Json list = Json::array();
    for (std::size_t k = 0; k < state_->history.done; ++k)
        list.push_back(write_move(state_->history.entries[k].move));
    return list;
}

Status Session::replay(const Json& script) {
    const Json& list =
        script.is_object() && script.contains("commands") ? script["commands"] : script;
    if (!list.is_array()) return wrong("is not a list of commands");
    for (std::size_t k = 0; k < list.size(); ++k) {
        const auto change = run(list[k]);
        if (!change.ok())
            return Error{change.error().code, change.error().message,
                         "command " + std::to_string(k + 1)};
    }
    return {};
}

Result<Bytes> Session::file() const {
    return state_->model->file();
}
Result<Measurement> Session::measure() const {
    return state_->model->measure(state_->view);
}
Result<Compression> Session::compress(double max_error, const Progress& progress) {
    if (!(max_error >= 0)) return wrong("the bound is negative or not a number");
    return state_->model->compress(max_error, progress);
}

}  // namespace relief::edit
