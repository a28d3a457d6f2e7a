#include "token.h"

#include <sys/random.h>

#include <array>
#include <cstdint>

namespace relief::editor {

Result<std::string> random_token() {
    std::array<std::uint8_t, 16> bits{};
    if (::getrandom(bits.data(), bits.size(), 0) != static_cast<ssize_t>(bits.size()))
        return Error{ErrorCode::Unsupported, "the system gives no random numbers", "getrandom"};
    constexpr std::string_view digits = "0123456789abcdef";
    std::string token;
    for (const std::uint8_t byte : bits) {
        token += digits[byte >> 4];
        token += digits[byte & 15];
    }
    return token;
}

bool is_same_token(std::string_view given, std::string_view token) {
    if (given.size() != token.size()) return false;
    unsigned differing = 0;
    for (std::size_t k = 0; k < token.size(); ++k)
        differing |= static_cast<unsigned char>(given[k]) ^ static_cast<unsigned char>(token[k]);
    return differing == 0;
}

}  // namespace relief::editor
