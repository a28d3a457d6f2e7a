#include "http_connection.h"

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "assets.h"
#include "page_socket.h"
#include "temporary_folder.h"

namespace relief::editor {

namespace beast = boost::beast;
namespace http = beast::http;
using namespace std::chrono_literals;
using boost::system::error_code;

namespace {

constexpr std::uint32_t kLargestHead = std::uint32_t{64} << 10;
constexpr std::uint64_t kLargestBody = std::uint64_t{4} << 30;
constexpr auto kHeadTime = 30s;
constexpr auto kBodyTime = 10min;

std::string_view view_of(beast::string_view text) {
    return {text.data(), text.size()};
}

/// A file name in a header: RFC 8187.
std::string encoded(const std::string& name) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string text;
    for (const char c : name) {
        const auto code = static_cast<unsigned char>(c);
        const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                           (c >= 'A' && c <= 'Z') || c == '-' || c == '.' || c == '_';
        if (plain) {
            text += c;
        } else {
            text += '%';
            text += digits[code >> 4];
            text += digits[code & 15];
        }
    }
    return text;
}

class Connection final : public std::enable_shared_from_this<Connection> {
  public:
    Connection(asio::ip::tcp::socket socket, Hub& hub, Seat seat)
        : stream_(std::move(socket)), hub_(hub), seat_(std::move(seat)) {}

    void start() {
        head_.header_limit(kLargestHead);
        head_.body_limit(kLargestBody);
        stream_.expires_after(kHeadTime);
        http::async_read_header(stream_, buffer_, head_,
                                [self = shared_from_this()](error_code failed, std::size_t) {
                                    if (failed == http::error::header_limit)
                                        return self->refuse(431);
                                    if (failed == http::error::body_limit) return self->refuse(413);
                                    if (!failed) self->follow();
                                });
    }

  private:
    using Read = void (Hub::*)(const std::string& path, Hub::Reply<Json> reply);

    void follow() {
        const auto& request = head_.get();
        const Route to =
            route({view_of(request.method_string()), view_of(request.target()),
                   view_of(request[http::field::host]), view_of(request[http::field::origin])},
                  hub_.access());
        switch (to.to) {
            case Route::To::Refused:
                return refuse(to.status);
            case Route::To::Asset:
                return send_asset(to.argument);
            case Route::To::Socket:
                return become_page();
            case Route::To::Open:
                return receive_file(to.argument, &Hub::open);
            case Route::To::Drape:
                return receive_file(to.argument, &Hub::drape);
            case Route::To::DrapePicture:
                return send_drape();
            case Route::To::Export:
                return send_export(to.argument);
        }
    }

    void become_page() {
        if (!beast::websocket::is_upgrade(head_.get())) return refuse(426);
        serve_page(std::move(stream_), head_.release(), hub_, std::move(seat_));
    }

    void send_asset(const std::string& path) {
        const Asset* asset = find_asset(path);
        if (!asset) return refuse(404);
        const bool compressed =
            http::token_list(head_.get()[http::field::accept_encoding]).exists("gzip");
        auto response = respond<http::string_body>(http::status::ok);
        response->set(http::field::content_type, std::string(content_type(path)));
        if (compressed) {
            response->set(http::field::content_encoding, "gzip");
            response->body().assign(reinterpret_cast<const char*>(asset->gzip.data()),
                                    asset->gzip.size());
        } else {
            response->body() = inflated(*asset);
        }
        send(std::move(response));
    }

    void refuse(unsigned status) {
        auto response = respond<http::string_body>(http::int_to_status(status));
        response->set(http::field::content_type, "text/plain; charset=utf-8");
        if (status == 405) response->set(http::field::allow, "GET, POST");
        if (status == 426) response->set(http::field::upgrade, "websocket");
        response->body() = std::string(http::obsolete_reason(response->result())) + "\n";
        send(std::move(response));
    }

    /// The body goes to a file of its name, which `read` then takes.
    void receive_file(const std::string& name, Read read) {
        auto folder = TemporaryFolder::create();
        if (!folder.ok()) return send_result(folder.error());
        folder_.emplace(*std::move(folder));
        const std::string path = folder_->path() + "/" + name;
        body_.emplace(std::move(head_));
        error_code failed;
        body_->get().body().open(path.c_str(), beast::file_mode::write, failed);
        if (failed)
            return send_result(Error{ErrorCode::CannotWrite, failed.message(), folder_->path()});
        stream_.expires_after(kBodyTime);
        http::async_read(stream_, buffer_, *body_,
                         [self = shared_from_this(), path, read](error_code broken, std::size_t) {
                             if (broken == http::error::body_limit) return self->refuse(413);
                             if (broken) return;
                             self->body_->get().body().close();
                             (self->hub_.*read)(path, [self](const Result<Json>& result) {
                                 self->send_result(result);
                             });
                         });
    }

    void send_result(const Result<Json>& result) {
        auto response = respond<http::string_body>(
            result.ok() ? http::status::ok : http::status::unprocessable_entity);
        response->set(http::field::content_type, "application/json");
        response->body() = text_of(result.ok() ? *result : error_json(result.error()));
        send(std::move(response));
    }

    void send_drape() {
        hub_.drape_picture([self = shared_from_this()](Result<Bytes> picture) {
            if (!picture.ok()) return self->send_result(picture.error());
            if (picture->empty()) return self->refuse(404);
            auto response = self->respond<http::vector_body<std::uint8_t>>(http::status::ok);
            response->set(http::field::content_type, "image/png");
            response->body() = *std::move(picture);
            self->send(std::move(response));
        });
    }

    void send_export(const std::string& format) {
        auto folder = TemporaryFolder::create();
        if (!folder.ok()) return send_result(folder.error());
        folder_.emplace(*std::move(folder));
        hub_.export_as(format, folder_->path(),
                       [self = shared_from_this()](const Result<std::string>& path) {
                           if (!path.ok()) return self->send_result(path.error());
                           self->send_file(*path);
                       });
    }

    void send_file(const std::string& path) {
        auto response = respond<http::file_body>(http::status::ok);
        error_code failed;
        response->body().open(path.c_str(), beast::file_mode::scan, failed);
        if (failed) return send_result(Error{ErrorCode::NotFound, failed.message(), path});
        const std::string name = std::filesystem::path(path).filename().string();
        response->set(http::field::content_type, std::string(content_type(name)));
        response->set(http::field::content_disposition,
                      "attachment; filename*=UTF-8''" + encoded(name));
        send(std::move(response));
    }

    /// An answer without content, with what all have.
    template <class Body>
    std::shared_ptr<http::response<Body>> respond(http::status status) {
        auto response = std::make_shared<http::response<Body>>(status, 11);
        const std::string port = std::to_string(hub_.access().port);
        response->set("Content-Security-Policy",
                      "default-src 'self'; img-src 'self' blob: data:; connect-src 'self' "
                      "ws://127.0.0.1:" +
                          port + " ws://localhost:" + port +
                          "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
                          "object-src 'none'");
        response->set("X-Content-Type-Options", "nosniff");
        response->set("Referrer-Policy", "no-referrer");
        response->set(http::field::cache_control, "no-store");
        response->keep_alive(false);
        return response;
    }

    template <class Body>
    void send(std::shared_ptr<http::response<Body>> response) {
        response->prepare_payload();
        stream_.expires_after(kBodyTime);
        http::async_write(
            stream_, *response, [self = shared_from_this(), response](error_code, std::size_t) {
                error_code ignored;
                self->stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
            });
    }

    beast::tcp_stream stream_;
    Hub& hub_;
    Seat seat_;
    beast::flat_buffer buffer_;
    http::request_parser<http::empty_body> head_;
    std::optional<TemporaryFolder> folder_;
    std::optional<http::request_parser<http::file_body>> body_;
};

}  // namespace

void serve_connection(asio::ip::tcp::socket socket, Hub& hub, Seat seat) {
    std::make_shared<Connection>(std::move(socket), hub, std::move(seat))->start();
}

}  // namespace relief::editor
