#include "hub.h"

#include <boost/asio/post.hpp>
#include <chrono>
#include <csignal>
#include <new>
#include <utility>

#include "events.h"
#include "http_connection.h"
#include "server.h"
#include "token.h"

namespace relief::editor {

using namespace std::chrono_literals;
using boost::system::error_code;

namespace {

/// Pages come back after a reload.
constexpr auto kAlone = 3s;
/// For the last words of sockets.
constexpr auto kGrace = 1s;
constexpr long kMostConnections = 64;

/// A file that was sent is known by its name, not by where we put it.
Error without_folder(Error error, const std::string& path) {
    const std::string folder = path.substr(0, path.rfind('/') + 1);
    for (std::string* text : {&error.message, &error.where})
        for (auto at = text->find(folder); at != std::string::npos; at = text->find(folder))
            text->erase(at, folder.size());
    return error;
}

}  // namespace

Hub::Hub(FileAccess files, std::string token)
    : files_(std::move(files)), access_{0, std::move(token)} {}

Status Hub::start(Document document, std::uint16_t port) {
    RELIEF_TRY(conversation_, Conversation::create(std::move(document), *this));
    RELIEF_CHECK(listen(port));
    worker_.emplace([this] { conversation_->refresh(); });
    signals_.add(SIGINT);
    signals_.add(SIGTERM);
    signals_.async_wait([this](error_code failed, int) {
        if (!failed) stop();
    });
    accept();
    return {};
}

Status Hub::listen(std::uint16_t port) {
    const asio::ip::tcp::endpoint here(asio::ip::address_v4::loopback(), port);
    error_code failed;
    acceptor_.open(here.protocol(), failed);
    if (!failed) acceptor_.set_option(asio::socket_base::reuse_address(true), failed);
    if (!failed) acceptor_.bind(here, failed);
    if (!failed) acceptor_.listen(asio::socket_base::max_listen_connections, failed);
    if (failed)
        return Error{ErrorCode::CannotWrite,
                     failed.message() +
                         "; choose another with --port, or none: then a free one is "
                         "taken",
                     "port " + std::to_string(port)};
    access_.port = acceptor_.local_endpoint(failed).port();
    return {};
}

void Hub::accept() {
    acceptor_.async_accept([this](error_code failed, asio::ip::tcp::socket socket) {
        if (!acceptor_.is_open()) return;
        if (!failed && seats_.use_count() <= kMostConnections)
            serve_connection(std::move(socket), *this, seats_);
        accept();
    });
}

void Hub::stop() {
    if (stopping_.exchange(true)) return;
    error_code ignored;
    acceptor_.close(ignored);
    lonely_.cancel();
    worker_->cancel();
    for (auto& [page, socket] : sockets_) socket->close(text_of(closing_event()));
    grace_.expires_after(kGrace);
    grace_.async_wait([this](error_code) { network_.stop(); });
    if (sockets_.empty()) network_.stop();
}

void Hub::end_when_alone() {
    lonely_.expires_after(kAlone);
    lonely_.async_wait([this](error_code failed) {
        if (!failed && sockets_.empty()) stop();
    });
}

PageId Hub::add(std::shared_ptr<PageSocket> socket) {
    const PageId page = ++last_page_;
    if (stopping_) socket->close(text_of(closing_event()));
    sockets_[page] = std::move(socket);
    worker_->post([this, page](const Wanted&) { conversation_->join(page); });
    return page;
}

void Hub::remove(PageId page) {
    sockets_.erase(page);
    worker_->post([this, page](const Wanted&) { conversation_->leave(page); });
    if (!sockets_.empty()) return;
    if (stopping_) return network_.stop();
    end_when_alone();
}

void Hub::send(PageId page, Message message) {
    asio::post(network_, [this, page, message = std::move(message)]() mutable {
        if (const auto found = sockets_.find(page); found != sockets_.end())
            found->second->send(std::move(message));
    });
}

void Hub::receive(PageId page, const std::string& text) {
    auto request = std::make_shared<Result<Request>>(read_request(text));
    if (request->ok() && (*request)->overtakes()) worker_->cancel();
    worker_->post([this, page, request](const Wanted& wanted) {
        conversation_->receive(page, *request, wanted);
        asio::post(network_, [this, page] {
            if (const auto found = sockets_.find(page); found != sockets_.end())
                found->second->answered();
        });
    });
}

template <class T, class Work>
void Hub::work(Work work, Reply<T> reply) {
    worker_->post(
        [this, work = std::move(work), reply = std::move(reply)](const Wanted& wanted) mutable {
            auto result = std::make_shared<Result<T>>(no_memory());
            try {
                *result = work(wanted);
            } catch (const std::bad_alloc&) {
                *result = no_memory();
            }
            asio::post(network_, [reply = std::move(reply), result] { reply(std::move(*result)); });
        });
}

void Hub::open(const std::string& path, Reply<Json> reply) {
    worker_->cancel();
    work<Json>(
        [this, path](const Wanted&) -> Result<Json> {
            auto document = files_.open(path, [this](double) { return !stopping_; });
            if (!document.ok()) return without_folder(document.error(), path);
            RELIEF_CHECK(conversation_->replace(*std::move(document)));
            return Json::object();
        },
        std::move(reply));
}

void Hub::drape(const std::string& path, Reply<Json> reply) {
    work<Json>(
        [this, path](const Wanted&) -> Result<Json> {
            auto rect = conversation_->drape(path);
            if (!rect.ok()) return without_folder(rect.error(), path);
            return rect;
        },
        std::move(reply));
}

void Hub::drape_picture(Reply<Bytes> reply) {
    work<Bytes>(
        [this](const Wanted&) -> Result<Bytes> { return Bytes(conversation_->drape_picture()); },
        std::move(reply));
}

void Hub::export_as(const std::string& format, const std::string& folder,
                    Reply<std::string> reply) {
    work<std::string>(
        [this, format, folder](const Wanted&) {
            return conversation_->export_as(format, folder, files_);
        },
        std::move(reply));
}

Status serve(Document document, const ServeOptions& options) {
    RELIEF_TRY(std::string token, random_token());
    Hub hub(options.files, std::move(token));
    RELIEF_CHECK(hub.start(std::move(document), options.port));
    if (options.listening) options.listening(hub.access().url());
    hub.run();
    return {};
}

}  // namespace relief::editor
