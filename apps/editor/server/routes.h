#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// What a request asks for, and whether it may. Source: docs/protocol.md, "Addresses".
namespace relief::editor {

/// Where the server is, and who may ask.
struct Access {
    std::uint16_t port = 0;
    std::string token;

    /// "http://127.0.0.1:PORT/TOKEN/".
    [[nodiscard]] std::string url() const;
};

/// What counts of a request's head. A header that is not there is empty.
struct RequestHead {
    std::string_view method;
    std::string_view target;
    std::string_view host;
    std::string_view origin;
};

struct Route {
    enum class To : std::uint8_t {
        Refused,  ///< with `status`
        Asset,    ///< `argument`: its path, "index.html"
        Socket,
        Open,   ///< `argument`: the file's name
        Drape,  ///< the same
        DrapePicture,
        Export,  ///< `argument`: the format
    };
    To to = To::Refused;
    unsigned status = 200;
    std::string argument;
};

/// 403 for another Host or Origin, 404 for another token or an address that is not known, 405 for
/// another method, 400 for a name or format that is missing or no file name.
[[nodiscard]] Route route(const RequestHead& head, const Access& access);

/// A name of a file, without directories: 1 to 200 bytes, no control characters, not hidden.
[[nodiscard]] bool is_file_name(std::string_view name);

}  // namespace relief::editor
