#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>

#include "io/text_lines.h"
#include "relief/io/file.h"
#include "relief/io/mesh.h"

namespace relief::io {

namespace {

using detail::Lines;
using detail::parse_number;
using detail::quoted;
using detail::Words;

constexpr std::int64_t kMostElements = std::numeric_limits<std::int32_t>::max();

Result<std::array<double, 3>> read_vertex(Words& words, const Lines& lines) {
    std::array<double, 3> vertex{};
    for (double& coordinate : vertex) {
        const std::string_view word = words.next();
        if (!parse_number(word, coordinate))
            return lines.error("a vertex needs three numbers, not " + quoted(word));
    }
    return vertex;
}

Error no_such_vertex(const Lines& lines, std::int64_t line, const std::string& index,
                     std::size_t count, const char* origin) {
    return lines.error_at(line, "index_out_of_range: a polygon names vertex " + index + " of " +
                                    std::to_string(count) + "; vertices count from " + origin);
}

Error too_many(const Lines& lines) {
    return lines.error(
        "too_many_elements: a mesh has at most 2^31 - 1 vertices, polygons and "
        "corners; split it");
}

/// What stands in front of OFF, and whether it is read.
Status check_keyword(std::string_view keyword, const Lines& lines) {
    std::string_view prefix = keyword;
    if (!prefix.ends_with("OFF"))
        return lines.error("an OFF file begins with the word OFF, not with " + quoted(keyword));
    prefix.remove_suffix(3);
    for (const std::string_view part : {"ST", "C", "N"})
        if (prefix.starts_with(part)) prefix.remove_prefix(part.size());
    if (prefix.empty()) return {};
    return Error{ErrorCode::Unsupported,
                 quoted(keyword) + " files are not read; write plain OFF, with x, y and z",
                 lines.error("").where};
}

struct OffCounts {
    std::int64_t vertices = 0;
    std::int64_t polygons = 0;
};

Result<OffCounts> read_off_head(Lines& lines) {
    Words words("");
    if (!lines.next(words)) return lines.error("the file is empty; an OFF file begins with OFF");
    RELIEF_CHECK(check_keyword(words.next(), lines));
    if (words.empty() && !lines.next(words))
        return lines.error("the numbers of vertices and polygons are missing");
    const std::string_view first = words.next();
    if (first == "BINARY")
        return Error{ErrorCode::Unsupported, "binary OFF files are not read; write text",
                     lines.error("").where};
    OffCounts counts;
    if (!parse_number(first, counts.vertices) || !parse_number(words.next(), counts.polygons) ||
        counts.vertices < 0 || counts.polygons < 0)
        return lines.error("the numbers of vertices and polygons are expected here");
    if (counts.vertices > kMostElements || counts.polygons > kMostElements) return too_many(lines);
    // "0 0 0\n" and "3 0 0 0\n" are the shortest lines: what can not be there is not allocated.
    const auto rest = static_cast<std::int64_t>(lines.bytes_left()) + 1;
    if (counts.vertices > rest / 6 || counts.polygons > rest / 8)
        return lines.error("the file is too short for " + std::to_string(counts.vertices) +
                           " vertices and " + std::to_string(counts.polygons) +
                           " polygons; it is cut off or its counts are wrong");
    return counts;
}

Status read_off_polygon(Words& words, const Lines& lines, PolygonMesh& mesh) {
    std::int64_t size = 0;
    if (!parse_number(words.next(), size) || size < 3)
        return lines.error("a polygon begins with the number of its corners, at least 3");
    std::vector<std::int32_t> polygon;
    for (std::int64_t k = 0; k < size; ++k) {
        const std::string_view word = words.next();
        std::int64_t vertex = 0;
        if (!parse_number(word, vertex))
            return lines.error("a polygon of " + std::to_string(size) +
                               " corners needs as many numbers of vertices, not " + quoted(word));
        if (vertex < 0 || vertex >= static_cast<std::int64_t>(mesh.vertices.size()))
            return no_such_vertex(lines, lines.number(), std::string(word), mesh.vertices.size(),
                                  "0");
        polygon.push_back(static_cast<std::int32_t>(vertex));
    }
    mesh.add_polygon(polygon);
    return {};
}

/// The corners of one face line, from 0, and the largest positive number among them.
class ObjFaces {
  public:
    Status read(Words& words, const Lines& lines, PolygonMesh& mesh) {
        polygon_.clear();
        while (!words.empty()) {
            RELIEF_TRY(const std::int32_t vertex,
                       read_corner(words.next(), lines, mesh.vertices.size()));
            polygon_.push_back(vertex);
        }
        if (polygon_.size() < 3) return lines.error("a face needs at least 3 corners");
        if (mesh.polygon_count() == kMostElements) return too_many(lines);
        mesh.add_polygon(polygon_);
        return {};
    }

    /// Faces may name vertices that follow them, so this is known at the end only.
    [[nodiscard]] Status check(const Lines& lines, std::size_t vertices) const {
        if (highest_ <= static_cast<std::int64_t>(vertices)) return {};
        return no_such_vertex(lines, highest_line_, std::to_string(highest_), vertices, "1");
    }

  private:
    Result<std::int32_t> read_corner(std::string_view word, const Lines& lines,
                                     std::size_t vertices) {
        const std::string_view first = word.substr(0, word.find('/'));
        std::int64_t index = 0;
        if (!parse_number(first, index) || !is_rest_of_corner(word.substr(first.size())))
            return lines.error("a corner of a face is v, v/vt, v//vn or v/vt/vn, not " +
                               quoted(word));
        const auto count = static_cast<std::int64_t>(vertices);
        if (index == 0 || index < -count || index > kMostElements)
            return no_such_vertex(lines, lines.number(), std::string(first), vertices, "1");
        if (index > highest_) {
            highest_ = index;
            highest_line_ = lines.number();
        }
        return static_cast<std::int32_t>(index > 0 ? index - 1 : count + index);
    }

    /// "", "/1", "//1" or "/1/1".
    static bool is_rest_of_corner(std::string_view rest) {
        if (rest.empty()) return true;
        rest.remove_prefix(1);
        const std::size_t slash = rest.find('/');
        std::int64_t ignored = 0;
        if (slash == std::string_view::npos) return parse_number(rest, ignored);
        return (slash == 0 || parse_number(rest.substr(0, slash), ignored)) &&
               parse_number(rest.substr(slash + 1), ignored);
    }

    std::vector<std::int32_t> polygon_;
    std::int64_t highest_ = 0;
    std::int64_t highest_line_ = 0;
};

std::string extension_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

bool says_off(std::string_view text) {
    const std::string_view word = Words(text.substr(0, text.find('\n'))).next();
    return word.size() <= 7 && word.ends_with("OFF");
}

}  // namespace

Result<PolygonMesh> parse_off(std::string_view text, const std::string& name) {
    Lines lines(text, name);
    RELIEF_TRY(const OffCounts counts, read_off_head(lines));
    PolygonMesh mesh;
    mesh.vertices.reserve(static_cast<std::size_t>(counts.vertices));
    mesh.offsets.reserve(static_cast<std::size_t>(counts.polygons) + 1);
    Words words("");
    for (std::int64_t k = 0; k < counts.vertices; ++k) {
        if (!lines.next(words))
            return lines.error("ends after " + std::to_string(k) + " of " +
                               std::to_string(counts.vertices) + " vertices; it is cut off");
        RELIEF_TRY(const auto vertex, read_vertex(words, lines));
        mesh.vertices.push_back(vertex);
    }
    for (std::int64_t k = 0; k < counts.polygons; ++k) {
        if (!lines.next(words))
            return lines.error("ends after " + std::to_string(k) + " of " +
                               std::to_string(counts.polygons) + " polygons; it is cut off");
        RELIEF_CHECK(read_off_polygon(words, lines, mesh));
        if (static_cast<std::int64_t>(mesh.corners.size()) > kMostElements) return too_many(lines);
    }
    if (lines.next(words))
        return lines.error("there is more than the " + std::to_string(counts.vertices) +
                           " vertices and " + std::to_string(counts.polygons) +
                           " polygons that the file claims; correct its counts");
    return mesh;
}

Result<PolygonMesh> parse_obj(std::string_view text, const std::string& name) {
    Lines lines(text, name);
    PolygonMesh mesh;
    ObjFaces faces;
    for (Words words(""); lines.next(words);) {
        const std::string_view keyword = words.next();
        if (keyword == "v") {
            if (static_cast<std::int64_t>(mesh.vertices.size()) == kMostElements)
                return too_many(lines);
            RELIEF_TRY(const auto vertex, read_vertex(words, lines));
            mesh.vertices.push_back(vertex);
        } else if (keyword == "f") {
            RELIEF_CHECK(faces.read(words, lines, mesh));
            if (static_cast<std::int64_t>(mesh.corners.size()) > kMostElements)
                return too_many(lines);
        }
    }
    RELIEF_CHECK(faces.check(lines, mesh.vertices.size()));
    return mesh;
}

Result<PolygonMesh> read_mesh(const std::string& path) {
    RELIEF_TRY(const auto bytes, read_file(path));
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::string extension = extension_of(path);
    if (says_off(text) || extension == ".off") return parse_off(text, path);
    if (extension == ".obj") return parse_obj(text, path);
    return Error{ErrorCode::Unsupported,
                 "is a mesh of a format that is not read; convert it to .off or .obj", path};
}

}  // namespace relief::io
