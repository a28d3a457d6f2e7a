#include "page_socket.h"

#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdint>
#include <deque>
#include <memory>
#include <utility>

namespace relief::editor {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;

namespace {

/// A command that names every point of a large net.
constexpr std::uint64_t kLargestRequest = std::uint64_t{16} << 20;
/// More requests are not read before some are answered.
constexpr int kMostUnanswered = 64;
/// More bytes do not wait behind the message that is on its way: the page does not read.
constexpr std::uint64_t kMostQueued = std::uint64_t{256} << 20;

asio::const_buffer bytes_of(const Message& message) {
    return std::visit([](const auto& content) { return asio::buffer(content); }, message);
}

class Socket final : public PageSocket, public std::enable_shared_from_this<Socket> {
  public:
    Socket(beast::tcp_stream stream, Hub& hub, Seat seat)
        : socket_(std::move(stream)), hub_(hub), seat_(std::move(seat)) {}

    void start(const http::request<http::empty_body>& request) {
        beast::get_lowest_layer(socket_).expires_never();
        socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
        socket_.read_message_max(kLargestRequest);
        socket_.auto_fragment(false);
        socket_.async_accept(request, [self = shared_from_this()](error_code failed) {
            if (failed) return;
            self->page_ = self->hub_.add(self);
            self->read();
        });
    }

    void send(Message message) override {
        if (closing_) return;
        enqueue(std::move(message));
        if (queued_ - bytes_of(queue_.front()).size() > kMostQueued) drop();
    }

    void answered() override {
        --unanswered_;
        if (std::exchange(paused_, false)) read();
    }

    void close(std::string last_words) override {
        if (std::exchange(closing_, true)) return;
        while (queue_.size() > 1) {
            queued_ -= bytes_of(queue_.back()).size();
            queue_.pop_back();
        }
        enqueue(std::move(last_words));
    }

  private:
    void read() {
        socket_.async_read(buffer_, [self = shared_from_this()](error_code failed, std::size_t) {
            self->have_read(failed);
        });
    }

    void have_read(error_code failed) {
        if (failed) return leave();
        if (!socket_.got_text())
            return socket_.async_close(websocket::close_code::unknown_data,
                                       [self = shared_from_this()](error_code) { self->leave(); });
        ++unanswered_;
        hub_.receive(page_, beast::buffers_to_string(buffer_.data()));
        buffer_.consume(buffer_.size());
        paused_ = unanswered_ >= kMostUnanswered;
        if (!paused_) read();
    }

    void enqueue(Message message) {
        queued_ += bytes_of(message).size();
        queue_.push_back(std::move(message));
        if (queue_.size() == 1) write();
    }

    void write() {
        socket_.text(std::holds_alternative<std::string>(queue_.front()));
        socket_.async_write(
            bytes_of(queue_.front()),
            [self = shared_from_this()](error_code failed, std::size_t) { self->written(failed); });
    }

    void written(error_code failed) {
        if (failed) return leave();
        queued_ -= bytes_of(queue_.front()).size();
        queue_.pop_front();
        if (!queue_.empty()) return write();
        if (closing_)
            socket_.async_close(websocket::close_code::going_away,
                                [self = shared_from_this()](error_code) { self->leave(); });
    }

    void drop() {
        closing_ = true;
        beast::get_lowest_layer(socket_).close();
    }

    void leave() {
        closing_ = true;
        if (const PageId page = std::exchange(page_, 0); page != 0) hub_.remove(page);
    }

    websocket::stream<beast::tcp_stream> socket_;
    Hub& hub_;
    Seat seat_;
    PageId page_ = 0;  ///< 0: not yet, or no longer
    beast::flat_buffer buffer_;
    std::deque<Message> queue_;  ///< the first is on its way
    std::uint64_t queued_ = 0;   ///< bytes of all
    int unanswered_ = 0;
    bool paused_ = false;
    bool closing_ = false;
};

}  // namespace

void serve_page(beast::tcp_stream stream, http::request<http::empty_body> request, Hub& hub,
                Seat seat) {
    std::make_shared<Socket>(std::move(stream), hub, std::move(seat))->start(request);
}

}  // namespace relief::editor
