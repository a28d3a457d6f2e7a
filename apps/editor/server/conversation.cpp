#include "conversation.h"

#include <new>
#include <utility>

#include "events.h"
#include "wire.h"

namespace relief::editor {

namespace {

Result<edit::Session> open_session(const Document& document) {
    auto session = edit::Session::open(document.file, document.options);
    if (session.ok()) return session;
    Error error = session.error();
    error.where = error.where.empty() ? document.name : document.name + ", " + error.where;
    return error;
}

/// Those of a net that are no longer where they were, by their places in it.
edit::NetGeometry moved_points(const edit::NetGeometry& before, const edit::NetGeometry& now) {
    edit::NetGeometry moved;
    moved.level = now.level;
    const bool corners = !now.corner.empty();
    for (std::size_t k = 0; k < now.position.size(); ++k) {
        if (now.position[k] == before.position[k] &&
            (!corners || now.corner[k] == before.corner[k]))
            continue;
        moved.point.push_back(static_cast<std::uint32_t>(k));
        moved.position.push_back(now.position[k]);
        if (corners) moved.corner.push_back(now.corner[k]);
    }
    return moved;
}

}  // namespace

Result<Conversation> Conversation::create(Document document, Outbox& outbox) {
    RELIEF_TRY(edit::Session session, open_session(document));
    return Conversation(std::move(document), std::move(session), outbox);
}

Conversation::Conversation(Document document, edit::Session session, Outbox& outbox)
    : document_(std::move(document)), session_(std::move(session)), outbox_(&outbox) {}

void Conversation::say_ok(PageId page, std::uint64_t id, Json members) {
    members.update(Json{{"id", id}, {"ok", true}});
    say(page, members);
}

void Conversation::say_error(PageId page, std::uint64_t id, const Json& error) {
    say(page, Json{{"id", id}, {"ok", false}, {"error", error}});
}

void Conversation::greet(PageId page) {
    say(page, hello_event(document_, session_, page == writer_));
    for (const std::string& notice : document_.notices) say(page, notice_event(notice));
}

void Conversation::join(PageId page) {
    pages_[page] = {};
    if (!writer_) writer_ = page;
    greet(page);
}

void Conversation::leave(PageId page) {
    pages_.erase(page);
    if (writer_ == page) writer_.reset();
}

Status Conversation::replace(Document document) {
    RELIEF_TRY(session_, open_session(document));
    document_ = std::move(document);
    compressed_.reset();
    drape_.clear();
    for (auto& [id, page] : pages_) {
        page = {};
        greet(id);
    }
    return {};
}

void Conversation::receive(PageId page, const Result<Request>& request, const Wanted& wanted) {
    if (pages_.count(page) == 0) return;
    if (!request.ok())
        return say(page,
                   Json{{"id", nullptr}, {"ok", false}, {"error", error_json(request.error())}});
    const bool writes = request->command || request->name == "save";
    if (writes && page != writer_)
        return say_error(page, request->id,
                         error_json("read_only", "another page edits this file; this one watches"));
    try {
        work(page, *request, wanted);
    } catch (const std::bad_alloc&) {
        say_error(page, request->id, error_json(no_memory()));
    }
}

void Conversation::work(PageId page, const Request& request, const Wanted& wanted) {
    if (request.command) return command(page, request);
    const Status status = question(page, request, wanted);
    if (!status.ok()) say_error(page, request.id, error_json(status.error()));
}

Status Conversation::adopt(const Page& page) {
    if (!page.view || session_.view() == *page.view) return {};
    RELIEF_CHECK(session_.set_view(*page.view));
    for (const edit::TileName& tile : page.tiles) session_.hold(tile);
    return {};
}

void Conversation::command(PageId page, const Request& request) {
    Status adopted = adopt(pages_[page]);
    if (!adopted.ok()) return say_error(page, request.id, error_json(adopted.error()));
    const auto change = session_.run(request.body);
    if (!change.ok()) return say_error(page, request.id, error_json(change.error()));
    say_ok(page, request.id);
    tell_change(page, *change, request.id);
}

void Conversation::tell_change(PageId page, const edit::Change& change, std::uint64_t id) {
    for (auto& [other, state] : pages_) {
        if (other == page) continue;
        say(other, changed_event(session_, change.touched, {}));
        state.stale = state.view.has_value();
    }
    say(page, changed_event(session_, change.touched, id));
    if (pages_[page].view) send_change(page, change, {id, session_.revision()});
}

void Conversation::send_change(PageId page, const edit::Change& change, const Stamp& stamp) {
    Page& state = pages_[page];
    if (!change.surface.at.empty()) outbox_->send(page, surface_patch(change.surface, stamp));
    for (const edit::TileGeometry& tile : change.tiles)
        if (state.tiles.count(tile.tile) > 0) outbox_->send(page, tile_patch(tile, stamp));
    if (state.net) send_net_change(page, *state.net, stamp);
}

void Conversation::send_net_change(PageId page, Net& net, const Stamp& stamp) {
    auto now = session_.net(net.level, net.window);
    if (!now.ok()) return say(page, notice_event(now.error().text()));
    const edit::NetGeometry moved = moved_points(net.sent, *now);
    net.sent = *std::move(now);
    if (!moved.point.empty()) outbox_->send(page, net_patch(moved, stamp));
}

void Conversation::refresh() {
    for (auto& [id, page] : pages_)
        if (std::exchange(page.stale, false)) refresh(id, page);
}

void Conversation::refresh(PageId id, Page& page) {
    try {
        const Status adopted = adopt(page);
        auto messages = adopted.ok() ? everything(page, {0, session_.revision()}) : adopted.error();
        if (!messages.ok()) return say(id, notice_event(messages.error().text()));
        for (Bytes& message : *messages) outbox_->send(id, std::move(message));
    } catch (const std::bad_alloc&) {
        say(id, notice_event(no_memory().text()));
    }
}

}  // namespace relief::editor
