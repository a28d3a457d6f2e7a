#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

/// The page's files, which are part of the program.
namespace relief::editor {

struct Asset {
    std::string_view path;  ///< "index.html", "assets/editor.js"
    std::span<const std::uint8_t> gzip;
};

/// Null: there is none.
[[nodiscard]] const Asset* find_asset(std::string_view path);
/// What was compressed.
[[nodiscard]] std::string inflated(const Asset& asset);

/// "text/html; charset=utf-8" for ".html", and so on; "application/octet-stream" for what is not
/// known.
[[nodiscard]] std::string_view content_type(std::string_view path);

namespace detail {
/// Written by embed_page.mjs at build time.
[[nodiscard]] std::span<const Asset> all_assets();
}  // namespace detail

}  // namespace relief::editor
