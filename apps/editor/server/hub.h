#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "conversation.h"
#include "outbox.h"
#include "routes.h"
#include "worker.h"

namespace relief::editor {

namespace asio = boost::asio;

/// A page's WebSocket, as the hub sees it. In the network's thread.
class PageSocket {
  public:
    PageSocket() = default;
    PageSocket(const PageSocket&) = delete;
    PageSocket& operator=(const PageSocket&) = delete;
    virtual ~PageSocket() = default;

    virtual void send(Message message) = 0;
    /// One of its requests was worked off.
    virtual void answered() = 0;
    /// Says so and closes; what was not sent is dropped.
    virtual void close(std::string last_words) = 0;
};

/// Each open connection keeps one.
using Seat = std::shared_ptr<const void>;

/// Where connections meet the conversation: sockets in the network's thread, which is the caller's
/// of run(), and the conversation in the worker's. All but send() is for the former.
class Hub final : public Outbox {
  public:
    Hub(FileAccess files, std::string token);

    /// Errors: those of Session::open; CannotWrite when the port can not be had.
    Status start(Document document, std::uint16_t port);
    /// Until nothing is left to serve.
    void run() { network_.run(); }

    [[nodiscard]] const Access& access() const { return access_; }

    [[nodiscard]] PageId add(std::shared_ptr<PageSocket> socket);
    void remove(PageId page);
    void receive(PageId page, const std::string& text);
    void send(PageId page, Message message) override;

    /// What is asked for by HTTP, and who gets the answer.
    template <class T>
    using Reply = std::function<void(Result<T>)>;
    void open(const std::string& path, Reply<Json> reply);
    void drape(const std::string& path, Reply<Json> reply);
    void drape_picture(Reply<Bytes> reply);
    void export_as(const std::string& format, const std::string& folder, Reply<std::string> reply);

  private:
    Status listen(std::uint16_t port);
    void accept();
    void stop();
    void end_when_alone();
    template <class T, class Work>
    void work(Work work, Reply<T> reply);

    asio::io_context network_{1};
    asio::ip::tcp::acceptor acceptor_{network_};
    asio::signal_set signals_{network_};
    asio::steady_timer lonely_{network_};
    asio::steady_timer grace_{network_};
    Seat seats_ = std::make_shared<char>();
    FileAccess files_;
    Access access_;
    std::map<PageId, std::shared_ptr<PageSocket>> sockets_;
    PageId last_page_ = 0;
    std::atomic<bool> stopping_{false};
    std::optional<Conversation> conversation_;  ///< the worker's
    std::optional<Worker> worker_;              ///< the last, so that it ends first
};

}  // namespace relief::editor
