#include "routes.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "token.h"

namespace relief::editor {

namespace {

bool is_own(std::string_view authority, std::uint16_t port) {
    const std::string suffix = ":" + std::to_string(port);
    return authority == "127.0.0.1" + suffix || authority == "localhost" + suffix;
}

bool may_ask(const RequestHead& head, const Access& access) {
    if (!is_own(head.host, access.port)) return false;
    constexpr std::string_view scheme = "http://";
    if (head.origin.empty()) return true;
    return head.origin.starts_with(scheme) && head.origin.substr(scheme.size()) == head.host;
}

/// %20 and the like; nothing if one is not complete.
std::optional<std::string> decoded(std::string_view text) {
    std::string plain;
    for (std::size_t k = 0; k < text.size(); ++k) {
        if (text[k] != '%') {
            plain += text[k];
            continue;
        }
        unsigned code = 0;
        const char* first = text.data() + k + 1;
        if (text.size() - k < 3 || std::from_chars(first, first + 2, code, 16).ptr != first + 2)
            return {};
        plain += static_cast<char>(code);
        k += 2;
    }
    return plain;
}

/// The value of a member of a query "a=1&b=2"; empty if it is missing.
std::string member(std::string_view query, std::string_view name) {
    while (!query.empty()) {
        const std::string_view item = query.substr(0, query.find('&'));
        query.remove_prefix(std::min(query.size(), item.size() + 1));
        if (item.size() > name.size() && item.starts_with(name) && item[name.size()] == '=')
            return decoded(item.substr(name.size() + 1)).value_or("");
    }
    return {};
}

Route refused(unsigned status) {
    return {Route::To::Refused, status, {}};
}

struct Address {
    std::string_view path;
    std::string_view method;
    Route::To to;
    std::string_view argument;  ///< the member of the query that is needed
};

constexpr std::array<Address, 5> kAddresses = {{
    {"socket", "GET", Route::To::Socket, ""},
    {"open", "POST", Route::To::Open, "name"},
    {"drape", "POST", Route::To::Drape, "name"},
    {"drape.png", "GET", Route::To::DrapePicture, ""},
    {"export", "GET", Route::To::Export, "format"},
}};

Route named_route(const Address& address, std::string_view method, std::string_view query) {
    if (method != address.method) return refused(405);
    if (address.argument.empty()) return {address.to, 200, {}};
    std::string argument = member(query, address.argument);
    return is_file_name(argument) ? Route{address.to, 200, std::move(argument)} : refused(400);
}

}  // namespace

std::string Access::url() const {
    return "http://127.0.0.1:" + std::to_string(port) + "/" + token + "/";
}

bool is_file_name(std::string_view name) {
    constexpr std::size_t longest = 200;
    if (name.empty() || name.size() > longest || name.front() == '.') return false;
    return std::none_of(name.begin(), name.end(), [](char c) {
        return c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    });
}

Route route(const RequestHead& head, const Access& access) {
    if (!may_ask(head, access)) return refused(403);
    std::string_view path = head.target.substr(0, head.target.find('?'));
    const std::string_view query =
        head.target.substr(std::min(head.target.size(), path.size() + 1));
    const std::size_t end = path.find('/', 1);
    if (!path.starts_with('/') || end == std::string_view::npos ||
        !is_same_token(path.substr(1, end - 1), access.token))
        return refused(404);
    path.remove_prefix(end + 1);
    for (const Address& address : kAddresses)
        if (path == address.path) return named_route(address, head.method, query);
    if (head.method != "GET") return refused(405);
    return {Route::To::Asset, 200, path.empty() ? "index.html" : std::string(path)};
}

}  // namespace relief::editor
