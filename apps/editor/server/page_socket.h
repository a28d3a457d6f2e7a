#pragma once

#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

#include "hub.h"

namespace relief::editor {

/// Answers a request for a WebSocket and becomes a page of the hub.
void serve_page(boost::beast::tcp_stream stream,
                boost::beast::http::request<boost::beast::http::empty_body> request, Hub& hub,
                Seat seat);

}  // namespace relief::editor
