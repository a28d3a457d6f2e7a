#pragma once

#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>

#include "relief/io/mesh.h"

/// What the fuzzers of the mesh readers run, and the tests on mutations: any text gives a mesh
/// whose corners exist, or an error with a place.
namespace relief::io::fuzz {

inline void require(bool condition) {
    if (!condition) std::abort();
}

inline void check(const Result<PolygonMesh>& mesh) {
    if (!mesh.ok()) {
        require(!mesh.error().message.empty() && mesh.error().where.starts_with("mesh, line "));
        return;
    }
    require(mesh->offsets.front() == 0);
    require(mesh->offsets.back() == static_cast<std::int64_t>(mesh->corners.size()));
    for (std::int64_t k = 0; k < mesh->polygon_count(); ++k) require(mesh->polygon(k).size() >= 3);
    for (const std::int32_t v : mesh->corners)
        require(v >= 0 && static_cast<std::size_t>(v) < mesh->vertices.size());
}

inline std::string_view text_of(std::span<const std::uint8_t> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline void off(std::span<const std::uint8_t> bytes) {
    check(parse_off(text_of(bytes), "mesh"));
}

inline void obj(std::span<const std::uint8_t> bytes) {
    check(parse_obj(text_of(bytes), "mesh"));
}

}  // namespace relief::io::fuzz
