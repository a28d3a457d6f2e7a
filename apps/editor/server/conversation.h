#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "document.h"
#include "outbox.h"
#include "relief/edit/session.h"
#include "request.h"
#include "wire.h"

namespace relief::editor {

/// Whether the work at hand is still wanted.
using Wanted = std::function<bool()>;

/// What pages and server say to each other about one open file: requests in, messages out. Knows no
/// sockets, and is for one thread.
///
/// Invariant: the session shows the view of the page that it last worked for, and holds the tiles
/// of that page; the writer is a page that is there.
class Conversation {
  public:
    /// `outbox` must outlive it. Errors: those of Session::open.
    [[nodiscard]] static Result<Conversation> create(Document document, Outbox& outbox);

    /// A page is there: it gets `hello`. It may write if no other page does.
    void join(PageId page);
    void leave(PageId page);

    /// Answers. An error: what could not be read is answered without an id.
    void receive(PageId page, const Result<Request>& request, const Wanted& wanted);
    /// Brings those up to date that only watch. To be called when nothing else is to do.
    void refresh();

    /// Another file takes the place of this one. On an error it stays.
    Status replace(Document document);

    /// Writes what the writer is shown as "relief", "script", "tif", "glb", "obj" or "ply" into a
    /// folder; returns the path, whose name suits a download. Errors: InvalidArgument for other
    /// formats and those that the kind does not have.
    [[nodiscard]] Result<std::string> export_as(const std::string& format,
                                                const std::string& folder, const FileAccess& files);

    /// Lays the image of a file over the surface; where its corners lie on the page: x0, y0, x1,
    /// y1.
    [[nodiscard]] Result<Json> drape(const std::string& path);
    /// It as PNG; empty without one.
    [[nodiscard]] const Bytes& drape_picture() const { return drape_; }

  private:
    /// A control net that a page shows, as it was sent.
    struct Net {
        int level = 0;
        std::optional<LatticeBox> window = {};
        edit::NetGeometry sent = {};
    };
    struct Page {
        std::optional<edit::View> view = {};  ///< none: it asked for nothing yet
        std::set<edit::TileName> tiles = {};
        std::optional<Net> net = {};
        bool stale = false;  ///< was not told of a change
    };
    Conversation(Document document, edit::Session session, Outbox& outbox);

    void say(PageId page, const Json& message) { outbox_->send(page, text_of(message)); }
    void say_ok(PageId page, std::uint64_t id, Json members = Json::object());
    void say_error(PageId page, std::uint64_t id, const Json& error);
    void greet(PageId page);

    /// The session works for this page from now on.
    Status adopt(const Page& page);
    void work(PageId page, const Request& request, const Wanted& wanted);
    void command(PageId page, const Request& request);
    void tell_change(PageId page, const edit::Change& change, std::uint64_t id);
    void send_change(PageId page, const edit::Change& change, const Stamp& stamp);
    void send_net_change(PageId page, Net& net, const Stamp& stamp);
    void refresh(PageId id, Page& page);

    Status question(PageId page, const Request& request, const Wanted& wanted);
    Status view(PageId page, const Request& request);
    /// What the page has, anew: its tiles, or the surface; and its net.
    [[nodiscard]] Result<std::vector<Bytes>> everything(Page& page, const Stamp& stamp) const;
    Status tiles(PageId page, const Request& request);
    Status forget(PageId page, const Request& request);
    Status net(PageId page, const Request& request);
    Status at(PageId page, const Request& request);
    Status compress(PageId page, const Request& request, const Wanted& wanted);
    Status errors(PageId page, const Request& request);
    Status save(PageId page, const Request& request);
    [[nodiscard]] Result<std::vector<edit::TileName>> tile_names(const Json& body) const;
    [[nodiscard]] Result<Bytes> shown_file() const;

    Document document_;
    edit::Session session_;
    Outbox* outbox_;
    std::map<PageId, Page> pages_;
    std::optional<PageId> writer_;
    std::shared_ptr<const ByteSource> compressed_;  ///< the file of the last compression
    Bytes drape_;
};

}  // namespace relief::editor
