#pragma once

#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "relief/codec/mesh_codec.h"
#include "relief/core/polygon_mesh.h"
#include "relief/io/image.h"
#include "relief/mesh/repair.h"
#include "relief/remesh/remesh.h"

/// The verbs on meshes with subdivision connectivity and on .relief files that hold one. The verbs'
/// own files parse the options and come here by what the input is.
namespace relief::cli {

/// A .relief file that holds a mesh. False for anything else, also if it is damaged.
[[nodiscard]] bool holds_mesh(const std::string& path);

[[nodiscard]] Result<codec::MeshFile> open_mesh_file(const std::string& path,
                                                     std::optional<std::uint64_t> max_bytes = {});

/// A mesh file, or a level of a .relief file of a mesh or of a quadrangulation.
[[nodiscard]] Result<PolygonMesh> read_polygons(const std::string& path, int level = 0);

/// How a mesh becomes one with subdivision connectivity.
struct RemeshFlags {
    std::optional<std::int64_t> base;
    std::optional<double> features;
    std::optional<Length> tolerance;

    void add_to(CLI::App& verb);
    /// As a fraction of the diagonal, if one was asked for.
    [[nodiscard]] std::optional<double> tolerance_of(const PolygonMesh& mesh) const;

    friend bool operator==(const RemeshFlags&, const RemeshFlags&) = default;
};
[[nodiscard]] Json remesh_json(const remesh::Remeshed& remeshed);
[[nodiscard]] std::string remesh_text(const remesh::Remeshed& remeshed);

/// What --repair did, as a line.
[[nodiscard]] std::string repair_text(const mesh::RepairCounts& counts);

struct MeshEncodeVerb {
    std::string in;
    std::string out;
    codec::Goal goal;
    codec::MeshDistance distance = codec::MeshDistance::Vertices;
    bool reorder = false;
    bool repair = false;
    std::optional<double> alpha = {};
    std::string lift = {};     ///< lift_name; empty: the library's choice
    bool of_diagonal = false;  ///< the goal is in units of the diagonal of the mesh
    std::optional<RemeshFlags> remesh = {};
    int effort = 1;  ///< codec::ScanEffort
};
/// Whether `encode` takes a mesh as a subdivision surface: it is asked to, or the mesh is not made
/// of quads over the plane.
[[nodiscard]] Result<bool> is_subdivision(const std::string& path, const SchemeOptions& scheme);
[[nodiscard]] Result<Outcome> encode_mesh(const MeshEncodeVerb& verb, const SchemeOptions& scheme,
                                          const Globals& globals);
[[nodiscard]] Result<Outcome> decode_mesh(const std::string& in, const std::string& out, int level,
                                          std::optional<std::uint64_t> max_bytes);
[[nodiscard]] Result<Outcome> info_of_mesh_file(const std::string& path);
/// Vertex by vertex, or by the distance of the surfaces.
[[nodiscard]] Result<Outcome> compare_meshes(const std::string& a, const std::string& b,
                                             bool surface);
/// `moves`: "INDEX:DX,DY,DZ".
[[nodiscard]] Result<Outcome> edit_mesh(const std::string& in, const std::string& out, int level,
                                        const std::vector<std::string>& moves);
/// Writes a file that is `in` with more moves, and says what they did.
[[nodiscard]] Result<Outcome> write_edited_mesh(const std::string& in, const std::string& out,
                                                Bytes edited);

/// What was left out of a file of some format, as a line; empty if nothing was.
[[nodiscard]] std::string left_out(const std::vector<std::string>& names);

}  // namespace relief::cli
