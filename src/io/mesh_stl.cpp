#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "io/extension.h"
#include "io/mesh_formats.h"
#include "io/text_lines.h"
#include "io/weld.h"

namespace relief::io {

namespace detail {

namespace {

constexpr std::size_t kHeader = 80;
constexpr std::size_t kStart = kHeader + 4;  ///< of the first facet
constexpr std::size_t kFacet = 50;           ///< normal, three corners, two bytes

/// Facets of three corners each, three numbers a corner, become polygons of common vertices.
LoadedMesh welded_mesh(const std::vector<double>& places) {
    const Welded welded = weld(places, 3);
    LoadedMesh loaded;
    for (const std::int32_t first : welded.firsts) {
        const double* place = places.data() + 3 * static_cast<std::size_t>(first);
        loaded.mesh.vertices.push_back({place[0], place[1], place[2]});
    }
    for (std::size_t k = 0; k < welded.numbers.size(); k += 3) {
        const auto facet = std::span(welded.numbers).subspan(k, 3);
        if (facet[0] == facet[1] || facet[1] == facet[2] || facet[2] == facet[0]) {
            ++loaded.degenerate_facets;
        } else {
            loaded.mesh.add_polygon(facet);
        }
    }
    return loaded;
}

Result<LoadedMesh> read_binary(std::span<const std::uint8_t> bytes, const std::string& name) {
    const auto error = [&](std::size_t at, std::string message) {
        return Error{ErrorCode::BadInput, std::move(message), fmt::format("{}, byte {}", name, at)};
    };
    if (bytes.size() < kStart)
        return error(bytes.size(), "an STL file has at least 84 bytes; it is cut off");
    const std::size_t facets = load_number<std::uint32_t>(bytes.data() + kHeader);
    if (bytes.size() != kStart + kFacet * facets)
        return error(kHeader,
                     fmt::format("{} facets take {} bytes, but the file has {}; it is cut off or "
                                 "its count is wrong",
                                 facets, kStart + kFacet * facets, bytes.size()));
    if (static_cast<std::int64_t>(3 * facets) > kMostElements) return error(kHeader, kTooMany);
    std::vector<double> places;
    places.reserve(9 * facets);
    for (std::size_t k = 0; k < 9 * facets; ++k) {
        const std::size_t at = kStart + k / 9 * kFacet + (3 + k % 9) * sizeof(float);
        const auto coordinate = load_number<float>(bytes.data() + at);
        if (!std::isfinite(coordinate))
            return error(at, "non_finite_vertex: a coordinate is not a finite number; repair it");
        places.push_back(coordinate);
    }
    return welded_mesh(places);
}

/// The text is a sequence of facets, whatever solids and loops they are in.
Result<LoadedMesh> read_ascii(std::string_view text, const std::string& name) {
    Lines lines(text, name, Syntax::Plain);
    std::vector<double> places;
    bool inside = false;       // of a facet
    std::size_t first = 0;     // where its corners begin
    std::string last_keyword;  // a file that is complete ends with endsolid
    for (Words words(""); lines.next(words);) {
        last_keyword = lower_case(std::string(words.next()));
        if (last_keyword == "vertex") {
            if (!inside) return lines.error("a vertex stands outside of a facet");
            std::array<double, 3> place{};
            RELIEF_CHECK(read_numbers(words, lines, "vertex", place));
            places.insert(places.end(), place.begin(), place.end());
        } else if (last_keyword == "facet") {
            if (inside) return lines.error("a facet begins inside of another; end it first");
            inside = true;
            first = places.size();
        } else if (last_keyword == "endfacet") {
            if (!inside || places.size() != first + 9)
                return lines.error("a facet has 3 vertices, between facet and endfacet");
            if (static_cast<std::int64_t>(places.size() / 3) > kMostElements)
                return lines.error(kTooMany);
            inside = false;
        } else if (last_keyword != "solid" && last_keyword != "outer" &&
                   last_keyword != "endloop" && last_keyword != "endsolid") {
            return lines.error(detail::quoted(last_keyword) + " is not a word of an STL file");
        }
    }
    if (inside || last_keyword != "endsolid")
        return lines.error("the file ends before endsolid; it is cut off");
    return welded_mesh(places);
}

}  // namespace

bool is_ascii_stl(std::span<const std::uint8_t> bytes) {
    const std::string_view head = text_of(bytes).substr(0, kHeader);
    // Some binary files begin with the word solid, too.
    return lower_case(std::string(Words(head.substr(0, head.find('\n'))).next())) == "solid" &&
           !is_binary_stl(bytes);
}

bool is_binary_stl(std::span<const std::uint8_t> bytes) {
    return bytes.size() >= kStart &&
           bytes.size() ==
               kStart + kFacet * std::size_t{load_number<std::uint32_t>(bytes.data() + kHeader)};
}

Result<EncodedMesh> encode_stl(const PolygonMesh& mesh) {
    std::size_t facets = 0;
    for (std::int64_t k = 0; k < mesh.polygon_count(); ++k) facets += mesh.polygon(k).size() - 2;
    if (facets > std::numeric_limits<std::uint32_t>::max())
        return Error{ErrorCode::BadInput, "too_many_elements: STL holds at most 2^32 - 1 triangles",
                     ""};
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        for (const double coordinate : mesh.vertices[v])
            if (!fits_float(coordinate))
                return Error{ErrorCode::BadInput,
                             "non_finite_vertex: a coordinate is too large for STL, which holds "
                             "floats; write .ply or .obj",
                             fmt::format("vertex {}", v)};
    EncodedMesh file;
    std::string& bytes = file.bytes;
    bytes.reserve(kStart + kFacet * facets);
    bytes.assign("binary STL");  // anything but "solid", which begins ascii files
    bytes.resize(kHeader);
    append_little_endian(bytes, static_cast<std::uint32_t>(facets));
    for (std::int64_t k = 0; k < mesh.polygon_count(); ++k) {
        const auto polygon = mesh.polygon(k);
        const auto place = [&](std::size_t corner) -> const Vec3& {
            return mesh.vertices[static_cast<std::size_t>(polygon[corner])];
        };
        for_fan(polygon.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
            const Vec3 normal = unit(area_normal(place(a), place(b), place(c)), Vec3{});
            for (const Vec3* vector : {&normal, &place(a), &place(b), &place(c)})
                for (const double number : *vector)
                    append_little_endian(bytes, static_cast<float>(number));
            bytes.append(2, '\0');
        });
    }
    for (const MeshAttribute& attribute : mesh.attributes) file.left_out.push_back(attribute.name);
    for (std::string& name : extras_of(mesh)) file.left_out.push_back(std::move(name));
    return file;
}

}  // namespace detail

Result<LoadedMesh> parse_stl(std::span<const std::uint8_t> bytes, const std::string& name) {
    return detail::is_ascii_stl(bytes) ? detail::read_ascii(detail::text_of(bytes), name)
                                       : detail::read_binary(bytes, name);
}

}  // namespace relief::io
