#pragma once

#include <cstdint>
#include <optional>

#include "document.h"
#include "relief/edit/session.h"
#include "request.h"

/// What the server says by itself. Source: docs/protocol.md, "Events".
namespace relief::editor {

[[nodiscard]] Json hello_event(const Document& document, const edit::Session& session, bool writer);
/// cause: the id of the page's own command; none: another page's.
[[nodiscard]] Json changed_event(const edit::Session& session, std::uint64_t touched,
                                 std::optional<std::uint64_t> cause);
[[nodiscard]] Json progress_event(std::uint64_t id, double fraction);
[[nodiscard]] Json notice_event(const std::string& message);
[[nodiscard]] Json closing_event();

[[nodiscard]] Json json_of(const Vec3<double>& point);

}  // namespace relief::editor
