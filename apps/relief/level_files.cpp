#include "level_files.h"

#include <charconv>

#include "relief/codec/container.h"
#include "relief/io/file_kind.h"

namespace relief::cli {

bool holds(const std::string& path, std::string_view content) {
    if (io::recognise(path) != io::FileKind::Relief) return false;
    const auto source = io::open_source(path);
    if (!source.ok()) return false;
    const auto found = codec::content_of(*source);
    return found.ok() && *found == content;
}

std::string edits_text(std::size_t moves) {
    return fmt::format("edited by {} move{}", moves, moves == 1 ? "" : "s");
}

std::string levels_text(const Json& levels, const char* faces) {
    const bool bounded = levels.front().contains("surface_bound");
    std::string text = fmt::format("{:5} {:>12} {:>12} {:>18}{}\n", "level", "vertices", faces,
                                   "bytes to read", bounded ? "   surface within" : "");
    for (const Json& level : levels) {
        text += fmt::format("{:5} {:>12} {:>12} {:>18}", level["level"].get<int>(),
                            grouped(level["vertices"].get<std::int64_t>()),
                            grouped(level[faces].get<std::int64_t>()),
                            grouped(level["bytes"].get<std::int64_t>()));
        if (bounded) {
            const Json& bound = level["surface_bound"];
            text += "   " + (bound.is_null() ? "-" : shown(bound.get<double>()));
        }
        text += '\n';
    }
    return text;
}

std::optional<IndexedNumbers> indexed_numbers(const std::string& text) {
    IndexedNumbers result;
    const char* const end = text.data() + text.size();
    auto [at, error] = std::from_chars(text.data(), end, result.index);
    if (error != std::errc() || at == end || *at != ':') return {};
    do {
        const auto number = std::from_chars(at + 1, end, result.numbers.emplace_back());
        if (number.ec != std::errc()) return {};
        at = number.ptr;
    } while (at != end && *at == ',');
    if (at != end) return {};
    return result;
}

}  // namespace relief::cli
