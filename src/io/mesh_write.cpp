#include <fmt/format.h>

#include <cctype>
#include <iterator>
#include <string_view>

#include "relief/io/file.h"
#include "relief/io/mesh.h"

namespace relief::io {

namespace {

std::string off_text(const PolygonMesh& mesh) {
    std::string text;
    const auto out = std::back_inserter(text);
    fmt::format_to(out, "OFF\n{} {} 0\n", mesh.vertices.size(), mesh.polygon_count());
    for (const auto& [x, y, z] : mesh.vertices) fmt::format_to(out, "{} {} {}\n", x, y, z);
    for (std::int64_t k = 0; k < mesh.polygon_count(); ++k) {
        fmt::format_to(out, "{}", mesh.polygon(k).size());
        for (const std::int32_t v : mesh.polygon(k)) fmt::format_to(out, " {}", v);
        text += '\n';
    }
    return text;
}

std::string obj_text(const PolygonMesh& mesh) {
    std::string text;
    const auto out = std::back_inserter(text);
    for (const auto& [x, y, z] : mesh.vertices) fmt::format_to(out, "v {} {} {}\n", x, y, z);
    for (std::int64_t k = 0; k < mesh.polygon_count(); ++k) {
        text += 'f';
        for (const std::int32_t v : mesh.polygon(k))
            fmt::format_to(out, " {}", std::int64_t{v} + 1);
        text += '\n';
    }
    return text;
}

bool ends_with(std::string_view path, std::string_view extension) {
    if (path.size() <= extension.size()) return false;
    path.remove_prefix(path.size() - extension.size());
    return std::equal(path.begin(), path.end(), extension.begin(), [](unsigned char a, char b) {
        return static_cast<char>(std::tolower(a)) == b;
    });
}

}  // namespace

Status write_mesh(const std::string& path, const PolygonMesh& mesh) {
    const bool off = ends_with(path, ".off");
    if (!off && !ends_with(path, ".obj"))
        return Error{ErrorCode::InvalidArgument, "a mesh is written as .off or .obj; choose one",
                     path};
    const std::string text = off ? off_text(mesh) : obj_text(mesh);
    return write_file_atomically(path,
                                 {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace relief::io
