#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "relief/core/stream.h"

namespace relief::editor {

/// A WebSocket's page, by a number that is not used again.
using PageId = std::uint64_t;

/// Text or binary.
using Message = std::variant<std::string, Bytes>;

/// Where messages to pages go.
class Outbox {
  public:
    Outbox() = default;
    Outbox(const Outbox&) = delete;
    Outbox& operator=(const Outbox&) = delete;
    virtual ~Outbox() = default;

    /// In order for each page; nothing for a page that has left.
    virtual void send(PageId page, Message message) = 0;
};

}  // namespace relief::editor
