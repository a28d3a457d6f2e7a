#include "request.h"

#include "relief/core/json.h"

namespace relief::editor {

namespace {

/// A command has a list in an object in an object at most.
constexpr int kDeepest = 8;

Error bad(const char* message) {
    return {ErrorCode::BadInput, message, "message of the page"};
}

const char* code_name(ErrorCode code) {
    switch (code) {
        case ErrorCode::InvalidArgument:
            return "invalid_argument";
        case ErrorCode::BadInput:
            return "bad_input";
        case ErrorCode::BadFile:
            return "bad_file";
        case ErrorCode::NotFound:
            return "not_found";
        case ErrorCode::CannotWrite:
            return "cannot_write";
        case ErrorCode::Unsupported:
            return "unsupported";
        case ErrorCode::Cancelled:
            return "cancelled";
    }
    return "";
}

}  // namespace

Result<Request> read_request(std::string_view text) {
    Request request;
    request.body = parse_json<Json>(text, kDeepest);
    const Json& body = request.body;
    if (!body.is_object()) return bad("is no JSON object, or one that is nested too deeply");
    const auto id = body.find("id");
    if (id == body.end() || !id->is_number_unsigned()) return bad("\"id\" is not a whole number");
    request.id = id->get<std::uint64_t>();
    request.command = body.contains("do");
    if (request.command == body.contains("ask")) return bad("has not one of \"do\" and \"ask\"");
    const Json& name = body[request.command ? "do" : "ask"];
    if (!name.is_string()) return bad("\"do\" or \"ask\" is not a name");
    request.name = name.get<std::string>();
    return request;
}

Json error_json(const Error& error) {
    return {{"code", code_name(error.code)}, {"message", error.message}, {"where", error.where}};
}

Json error_json(const char* code, std::string message) {
    return {{"code", code}, {"message", std::move(message)}, {"where", ""}};
}

Error no_memory() {
    return {ErrorCode::BadInput, "there is not enough memory for that", ""};
}

std::string text_of(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace relief::editor
