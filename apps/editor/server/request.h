#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "relief/core/result.h"

/// Text messages of the page. Source: docs/protocol.md, "Text messages".
namespace relief::editor {

using Json = nlohmann::json;

// NOLINTNEXTLINE(bugprone-exception-escape): JSON is moved without exceptions
struct Request {
    std::uint64_t id = 0;
    bool command = false;  ///< "do", which changes the surface; else "ask"
    std::string name;      ///< of the command or question
    Json body;             ///< all of it

    /// An unfinished compression is not waited for.
    [[nodiscard]] bool overtakes() const { return command || name == "compress"; }
};

/// Errors: BadInput for what is no JSON object, is nested too deeply, or has no id or not one of
/// "do" and "ask".
[[nodiscard]] Result<Request> read_request(std::string_view text);

/// An error as the page reads it. {"code", "message", "where"}.
[[nodiscard]] Json error_json(const Error& error);
/// The same for what the error codes do not say.
[[nodiscard]] Json error_json(const char* code, std::string message);

/// What becomes of std::bad_alloc.
[[nodiscard]] Error no_memory();

/// One line of text; what is not UTF-8 is replaced.
[[nodiscard]] std::string text_of(const Json& json);

}  // namespace relief::editor
