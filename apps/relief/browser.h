#pragma once

#include <string>

namespace relief::cli {

/// Shows an address in the user's browser: the first command of $BROWSER (names between colons)
/// that can be started, or xdg-open. Does not wait. False: there is none.
bool open_browser(const std::string& url);

}  // namespace relief::cli
