#pragma once

#include <boost/asio/ip/tcp.hpp>

#include "hub.h"

namespace relief::editor {

/// Reads one request and answers it, or makes a page's WebSocket of the connection. The hub must
/// outlive the connection.
void serve_connection(asio::ip::tcp::socket socket, Hub& hub, Seat seat);

}  // namespace relief::editor
