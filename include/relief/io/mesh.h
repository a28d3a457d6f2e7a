#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "relief/core/polygon_mesh.h"
#include "relief/core/result.h"

/// Polygon meshes from and to files: OBJ, OFF, PLY, STL; to GLB. docs/meshes.md says what each
/// format keeps.
///
/// Readers take the bytes of a file and its name for messages. What they deliver passes
/// relief::check. Errors: BadInput, or Unsupported for variants that are not read, in
/// "name, line n" of a text or "name, byte n" of a binary file. Time is O(n log n) of the bytes,
/// memory at most about 16 times as much as they, whatever the file claims.
namespace relief::io {

/// An Object File Format text: OFF with the prefixes ST, C and N for "uv", "colour" and "normal";
/// one vertex or polygon a line, comments from # on. Colours of whole numbers to 255 are UInt8.
/// Colours of polygons are left out. Unsupported: binary files and other dimensions.
[[nodiscard]] Result<PolygonMesh> parse_off(std::span<const std::uint8_t> bytes,
                                            const std::string& name);

/// A Wavefront OBJ text: v (x y z, and perhaps w or r g b or r g b a), vt, vn, f, g, o, usemtl, s,
/// mtllib, and the tags `t crease` and `t corner` of OpenSubdiv's shapes, whose vertices count from
/// 0: `t crease 2/1/0 a b sharpness`; more vertices are a chain, with one sharpness or one an edge;
/// 10 and more is infinite. All other lines are left out. "uv" and "normal" belong to the vertices
/// if all corners name the same number for v and vt or vn, and are face-varying otherwise.
[[nodiscard]] Result<PolygonMesh> parse_obj(std::span<const std::uint8_t> bytes,
                                            const std::string& name);

/// A PLY file, ascii or binary of either byte order. Of the vertices x y z, red green blue alpha,
/// nx ny nz, and for "uv" s t p, u v w or texture_u texture_v; of the faces vertex_indices or
/// vertex_index and texcoord lists; and what write_mesh adds (docs/meshes.md). All else is skipped.
[[nodiscard]] Result<PolygonMesh> parse_ply(std::span<const std::uint8_t> bytes,
                                            const std::string& name);

/// A mesh, and what its file held but a mesh can not.
struct LoadedMesh {
    PolygonMesh mesh;
    std::int64_t degenerate_facets = 0;  ///< of STL: two corners at one place; they are dropped
};

/// An STL file, binary or ascii. Corners at the same place (-0 equals 0) become one vertex, in
/// order of first appearance.
[[nodiscard]] Result<LoadedMesh> parse_stl(std::span<const std::uint8_t> bytes,
                                           const std::string& name);

/// Reads a file, which is recognised by its content or else by its extension. Errors: NotFound;
/// those of the parsers; Unsupported for other formats.
[[nodiscard]] Result<LoadedMesh> read_mesh(const std::string& path);

enum class PlyEncoding : std::uint8_t { Binary, Ascii };

/// The axis of a mesh that points up.
enum class Up : std::uint8_t { Y, Z };

struct MeshWriteOptions {
    PlyEncoding ply = PlyEncoding::Binary;  ///< binary is little endian
    /// For GLB, where y is up: surfaces over a plane, whose heights are z, are turned by the node.
    Up up = Up::Y;
};

/// Writes .obj, .off, .ply, .stl or .glb, by the extension. Numbers in text have the fewest digits
/// that give the same double; coordinates of PLY are floats if they all are exact as floats.
/// Returns the names of what the format can not hold and was left out: of attributes, keywords of
/// labels, "mtllib", "crease", "corner". The file appears only when it is complete. Errors:
/// InvalidArgument for another extension; BadInput for a mesh that does not pass relief::check, is
/// not finite as floats (STL, GLB), has no polygon (GLB) or too many (STL, GLB); CannotWrite.
/// Complexity: O(size), GLB with face-varying attributes O(size log size).
[[nodiscard]] Result<std::vector<std::string>> write_mesh(const std::string& path,
                                                          const PolygonMesh& mesh,
                                                          const MeshWriteOptions& options = {});

}  // namespace relief::io
