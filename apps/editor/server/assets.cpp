#include "assets.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <utility>

namespace relief::editor {

const Asset* find_asset(std::string_view path) {
    const auto assets = detail::all_assets();
    const auto found = std::find_if(assets.begin(), assets.end(),
                                    [&](const Asset& asset) { return asset.path == path; });
    return found == assets.end() ? nullptr : &*found;
}

std::string inflated(const Asset& asset) {
    constexpr int gzip_window = 15 + 16;
    z_stream stream{};
    std::string text;
    if (inflateInit2(&stream, gzip_window) != Z_OK) return text;
    // zlib does not write to its input.
    stream.next_in = const_cast<Bytef*>(asset.gzip.data());
    stream.avail_in = static_cast<uInt>(asset.gzip.size());
    std::array<char, 1 << 16> room;
    for (int state = Z_OK; state == Z_OK;) {
        stream.next_out = reinterpret_cast<Bytef*>(room.data());
        stream.avail_out = static_cast<uInt>(room.size());
        state = inflate(&stream, Z_NO_FLUSH);
        text.append(room.data(), room.size() - stream.avail_out);
    }
    inflateEnd(&stream);
    return text;
}

std::string_view content_type(std::string_view path) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 10> types = {{
        {".html", "text/html; charset=utf-8"},
        {".js", "text/javascript; charset=utf-8"},
        {".css", "text/css; charset=utf-8"},
        {".svg", "image/svg+xml"},
        {".png", "image/png"},
        {".ico", "image/x-icon"},
        {".json", "application/json"},
        {".woff2", "font/woff2"},
        {".tif", "image/tiff"},
        {".glb", "model/gltf-binary"},
    }};
    for (const auto& [extension, type] : types)
        if (path.ends_with(extension)) return type;
    return "application/octet-stream";
}

}  // namespace relief::editor
