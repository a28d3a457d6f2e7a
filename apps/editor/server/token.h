#pragma once

#include <string>
#include <string_view>

#include "relief/core/result.h"

namespace relief::editor {

/// 128 bits of the system's random source as 32 hexadecimal digits. Errors: Unsupported.
[[nodiscard]] Result<std::string> random_token();

/// Takes the same time wherever they differ.
[[nodiscard]] bool is_same_token(std::string_view given, std::string_view token);

}  // namespace relief::editor
