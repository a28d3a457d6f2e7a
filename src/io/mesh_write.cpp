#include "io/extension.h"
#include "io/mesh_formats.h"
#include "relief/io/file.h"

namespace relief::io {

namespace detail {

std::vector<std::string> extras_of(const PolygonMesh& mesh) {
    std::vector<std::string> names;
    for (const FaceLabels& labels : mesh.labels) names.push_back(labels.keyword);
    if (!mesh.libraries.empty()) names.emplace_back("mtllib");
    if (!mesh.creases.empty()) names.emplace_back("crease");
    if (!mesh.sharp_vertices.empty()) names.emplace_back("corner");
    return names;
}

}  // namespace detail

namespace {

Result<detail::EncodedMesh> encode(const std::string& extension, const PolygonMesh& mesh,
                                   const MeshWriteOptions& options) {
    if (extension == ".obj") return detail::encode_obj(mesh);
    if (extension == ".off") return detail::encode_off(mesh);
    if (extension == ".ply") return detail::encode_ply(mesh, options.ply);
    if (extension == ".stl") return detail::encode_stl(mesh);
    if (extension == ".glb") return detail::encode_glb(mesh, options.up);
    return Error{ErrorCode::InvalidArgument,
                 "a mesh is written as .obj, .off, .ply, .stl or .glb; choose one", ""};
}

Error located(Error error, const std::string& path) {
    error.where = error.where.empty() ? path : path + ", " + error.where;
    return error;
}

}  // namespace

Result<std::vector<std::string>> write_mesh(const std::string& path, const PolygonMesh& mesh,
                                            const MeshWriteOptions& options) {
    if (const Status valid = check(mesh); !valid.ok()) return located(valid.error(), path);
    auto file = encode(detail::extension_of(path), mesh, options);
    if (!file.ok()) return located(file.error(), path);
    const std::string& bytes = file->bytes;
    RELIEF_CHECK(write_file_atomically(
        path, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}));
    return std::move(file->left_out);
}

}  // namespace relief::io
