#include "io/extension.h"
#include "io/mesh_formats.h"
#include "io/text_lines.h"
#include "relief/io/file.h"

namespace relief::io {

namespace {

enum class Format { Obj, Off, Ply, Stl, Glb, Unknown };

Format format_of(std::span<const std::uint8_t> bytes, const std::string& extension) {
    const std::string_view text = detail::text_of(bytes);
    const std::string_view word =
        detail::Words(text.substr(0, std::min<std::size_t>(text.find('\n'), 80))).next();
    if (word == "ply") return Format::Ply;
    if (text.starts_with("glTF")) return Format::Glb;
    if (detail::is_off_keyword(word)) return Format::Off;
    if (extension == ".obj") return Format::Obj;
    if (detail::is_ascii_stl(bytes) || detail::is_binary_stl(bytes)) return Format::Stl;
    if (extension == ".off") return Format::Off;
    if (extension == ".ply") return Format::Ply;
    if (extension == ".stl") return Format::Stl;
    return extension == ".glb" ? Format::Glb : Format::Unknown;
}

Result<LoadedMesh> loaded(Result<PolygonMesh> mesh) {
    if (!mesh.ok()) return mesh.error();
    return LoadedMesh{*std::move(mesh), 0};
}

}  // namespace

Result<LoadedMesh> read_mesh(const std::string& path) {
    RELIEF_TRY(const auto bytes, read_file(path));
    switch (format_of(bytes, detail::extension_of(path))) {
        case Format::Obj:
            return loaded(parse_obj(bytes, path));
        case Format::Off:
            return loaded(parse_off(bytes, path));
        case Format::Ply:
            return loaded(parse_ply(bytes, path));
        case Format::Stl:
            return parse_stl(bytes, path);
        case Format::Glb:
            return Error{ErrorCode::Unsupported,
                         "is a GLB file, which is written but not read; convert it to .ply or .obj",
                         path};
        case Format::Unknown:
            break;
    }
    return Error{ErrorCode::Unsupported,
                 "is a mesh of a format that is not read; convert it to .obj, .off, .ply or .stl",
                 path};
}

}  // namespace relief::io
