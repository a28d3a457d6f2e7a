#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace relief::io::detail {

inline std::string lower_case(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

/// With its point, in lower case: ".obj".
inline std::string extension_of(const std::string& path) {
    return lower_case(std::filesystem::path(path).extension().string());
}

}  // namespace relief::io::detail
