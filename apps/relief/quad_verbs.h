#pragma once

#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "relief/codec/polygons.h"
#include "relief/codec/quad_codec.h"
#include "relief/core/polygon_mesh.h"
#include "relief/core/vec2.h"

/// The verbs on quad meshes and on .relief files that hold one. The verbs' own files parse the
/// options and come here by what the input is.
namespace relief::cli {

/// A .relief file that holds a quadrangulation. False for anything else, also if it is damaged.
[[nodiscard]] bool holds_quads(const std::string& path);
/// A polygon mesh, or a .relief file that holds a mesh or a quadrangulation.
[[nodiscard]] bool is_mesh(const std::string& path);

[[nodiscard]] Result<codec::QuadFile> open_quads(const std::string& path,
                                                 std::optional<std::uint64_t> max_bytes = {});

/// Reads a mesh; of a .relief file the finest level. Errors: `not_a_quad` naming the polygon.
[[nodiscard]] Result<codec::QuadMesh> read_quads(const std::string& path);

[[nodiscard]] Result<Outcome> encode_quads(const std::string& in, const std::string& out,
                                           const SchemeOptions& scheme, const codec::Goal& goal);
[[nodiscard]] Result<Outcome> decode_quads(const std::string& in, const std::string& out, int level,
                                           std::optional<std::uint64_t> max_bytes);
[[nodiscard]] Result<Outcome> info_of_quads(const std::string& path);
[[nodiscard]] Result<Outcome> info_of_mesh(const std::string& path);
/// `moves`: "INDEX:DZ".
[[nodiscard]] Result<Outcome> edit_quads(const std::string& in, const std::string& out, int level,
                                         const std::vector<std::string>& moves);
/// Writes a file that is `in` with more moves, and says what they did.
[[nodiscard]] Result<Outcome> write_edited_quads(const std::string& in, const std::string& out,
                                                 Bytes edited);

}  // namespace relief::cli
