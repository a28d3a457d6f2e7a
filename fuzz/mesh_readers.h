#pragma once

#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

#include "io/mesh_formats.h"
#include "relief/io/mesh.h"

/// What the fuzzers of the mesh readers run, and the tests on mutations: any bytes give a mesh that
/// passes relief::check, or an error with a place.
namespace relief::io::fuzz {

inline void require(bool condition) {
    if (!condition) std::abort();
}

inline void check_mesh(const PolygonMesh& mesh) {
    require(relief::check(mesh).ok());
}

inline void check_error(const Error& error) {
    require(!error.message.empty());
    require(error.where.starts_with("mesh, line ") || error.where.starts_with("mesh, byte "));
}

inline std::span<const std::uint8_t> bytes_of(const std::string& bytes) {
    return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

inline void off(std::span<const std::uint8_t> bytes) {
    const auto mesh = parse_off(bytes, "mesh");
    if (!mesh.ok()) return check_error(mesh.error());
    check_mesh(*mesh);
}

inline void obj(std::span<const std::uint8_t> bytes) {
    const auto mesh = parse_obj(bytes, "mesh");
    if (!mesh.ok()) return check_error(mesh.error());
    check_mesh(*mesh);
    const auto again = parse_obj(bytes_of(detail::encode_obj(*mesh).bytes), "mesh");
    require(again.ok() && again->vertices == mesh->vertices && again->corners == mesh->corners &&
            again->labels == mesh->labels && again->creases == mesh->creases);
}

/// PLY keeps all that is read from it.
inline void ply(std::span<const std::uint8_t> bytes) {
    const auto mesh = parse_ply(bytes, "mesh");
    if (!mesh.ok()) return check_error(mesh.error());
    check_mesh(*mesh);
    for (const PlyEncoding encoding : {PlyEncoding::Binary, PlyEncoding::Ascii}) {
        const auto again = parse_ply(bytes_of(detail::encode_ply(*mesh, encoding).bytes), "mesh");
        require(again.ok() && *again == *mesh);
    }
}

inline void stl(std::span<const std::uint8_t> bytes) {
    const auto loaded = parse_stl(bytes, "mesh");
    if (!loaded.ok()) return check_error(loaded.error());
    check_mesh(loaded->mesh);
}

}  // namespace relief::io::fuzz
