#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "document.h"

namespace relief::editor {

struct ServeOptions {
    std::uint16_t port = 0;  ///< of 127.0.0.1; 0: any that is free
    FileAccess files = {};
    std::function<void(const std::string& url)> listening = {};  ///< called once
};

/// Serves the page for a document (docs/protocol.md) until 3 seconds after the last page closed, or
/// until SIGINT or SIGTERM. Errors: CannotWrite when the port can not be had; those of
/// Session::open.
Status serve(Document document, const ServeOptions& options);

}  // namespace relief::editor
