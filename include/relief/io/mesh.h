#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "relief/core/result.h"

/// Polygon meshes from and to OFF and OBJ files.
namespace relief::io {

/// Polygon k has the corners corners[offsets[k]] .. corners[offsets[k + 1] - 1], at least three,
/// which are numbers of vertices. Invariant of what is read: they exist.
struct PolygonMesh {
    std::vector<std::array<double, 3>> vertices;
    std::vector<std::int64_t> offsets = {0};
    std::vector<std::int32_t> corners;

    [[nodiscard]] std::int64_t polygon_count() const {
        return static_cast<std::int64_t>(offsets.size()) - 1;
    }
    [[nodiscard]] std::span<const std::int32_t> polygon(std::int64_t k) const {
        const auto first = static_cast<std::size_t>(offsets[static_cast<std::size_t>(k)]);
        const auto end = static_cast<std::size_t>(offsets[static_cast<std::size_t>(k) + 1]);
        return std::span(corners).subspan(first, end - first);
    }
    void add_polygon(std::span<const std::int32_t> polygon_corners) {
        corners.insert(corners.end(), polygon_corners.begin(), polygon_corners.end());
        offsets.push_back(static_cast<std::int64_t>(corners.size()));
    }

    friend bool operator==(const PolygonMesh&, const PolygonMesh&) = default;
};

/// A text file in the Object File Format: OFF, or with a prefix C, N, ST for colours, normals and
/// texture places, which are left out; one vertex or polygon a line, comments from # on. `name` is
/// the file in messages. Errors: BadInput "name, line n: .."; Unsupported for binary files and
/// other dimensions. Complexity: O(bytes) of time and memory.
[[nodiscard]] Result<PolygonMesh> parse_off(std::string_view text, const std::string& name);

/// A Wavefront OBJ file: lines v and f (corners v, v/vt, v//vn, v/vt/vn, negative ones count back
/// from the last vertex so far); all other lines are left out. Errors and complexity: as parse_off.
[[nodiscard]] Result<PolygonMesh> parse_obj(std::string_view text, const std::string& name);

/// Reads a file by its content (OFF) or extension (.obj, .off). Errors: NotFound; those of the
/// parsers; Unsupported for other formats.
[[nodiscard]] Result<PolygonMesh> read_mesh(const std::string& path);

/// Writes .off or .obj, by the extension; numbers have the fewest digits that give the same double.
/// Errors: InvalidArgument for another extension; CannotWrite.
[[nodiscard]] Status write_mesh(const std::string& path, const PolygonMesh& mesh);

}  // namespace relief::io
