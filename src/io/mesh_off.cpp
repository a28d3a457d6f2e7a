#include <fmt/format.h>

#include <array>
#include <iterator>

#include "io/mesh_formats.h"
#include "io/text_lines.h"

namespace relief::io {

namespace detail {

namespace {

/// What stands on the line of a vertex after its coordinates, in this order.
struct OffParts {
    int normal = 0;  ///< numbers, 0 or 3
    int colour = 0;  ///< 0, 3 or 4
    int uv = 0;      ///< 0 or 2

    [[nodiscard]] int count() const { return normal + colour + uv; }
};

struct OffHead {
    std::string keyword;
    std::int64_t vertices = 0;
    std::int64_t polygons = 0;
};

struct OffPrefixes {
    bool uv = false;
    bool colour = false;
    bool normal = false;
    bool known = false;
};

OffPrefixes prefixes_of(std::string_view word) {
    OffPrefixes found;
    const auto take = [&](std::string_view prefix) {
        const bool there = word.starts_with(prefix);
        if (there) word.remove_prefix(prefix.size());
        return there;
    };
    found.uv = take("ST");
    found.colour = take("C");
    found.normal = take("N");
    found.known = word == "OFF";
    return found;
}

class OffReader {
  public:
    OffReader(std::string_view text, const std::string& name) : lines_(text, name, Syntax::Off) {}

    Result<PolygonMesh> read() {
        RELIEF_TRY(const OffHead head, read_head());
        mesh_.vertices.reserve(static_cast<std::size_t>(head.vertices));
        mesh_.offsets.reserve(static_cast<std::size_t>(head.polygons) + 1);
        for (std::int64_t k = 0; k < head.vertices; ++k) {
            RELIEF_TRY(const Words words, next_line(k, head.vertices, "vertices"));
            if (k == 0) RELIEF_CHECK(set_parts(head.keyword, words));
            RELIEF_CHECK(read_vertex(words));
        }
        for (std::int64_t k = 0; k < head.polygons; ++k) {
            RELIEF_TRY(const Words words, next_line(k, head.polygons, "polygons"));
            RELIEF_CHECK(read_polygon(words));
        }
        if (Words words(""); lines_.next(words))
            return lines_.error(
                fmt::format("there is more than the {} vertices and {} polygons that the file "
                            "claims; correct its counts",
                            head.vertices, head.polygons));
        add_attribute("uv", parts_.uv, SampleType::Float64, uv_);
        add_attribute("colour", parts_.colour,
                      whole_colours_ ? SampleType::UInt8 : SampleType::Float64, colours_);
        add_attribute("normal", parts_.normal, SampleType::Float64, normals_);
        return std::move(mesh_);
    }

  private:
    Result<OffHead> read_head() {
        Words words("");
        if (!lines_.next(words))
            return lines_.error("the file is empty; an OFF file begins with OFF");
        OffHead head;
        head.keyword = words.next();
        RELIEF_CHECK(check_keyword(head.keyword));
        if (words.empty() && !lines_.next(words))
            return lines_.error("the numbers of vertices and polygons are missing");
        const std::string_view first = words.next();
        if (first == "BINARY") return unsupported("binary OFF files are not read; write text");
        if (!parse_number(first, head.vertices) || !parse_number(words.next(), head.polygons) ||
            head.vertices < 0 || head.polygons < 0)
            return lines_.error("the numbers of vertices and polygons are expected here");
        if (head.vertices > kMostElements || head.polygons > kMostElements)
            return lines_.error(kTooMany);
        // "0 0 0\n" and "3 0 0 0\n" are the shortest lines: what can not be there is not allocated.
        const auto rest = static_cast<std::int64_t>(lines_.bytes_left()) + 1;
        if (head.vertices > rest / 6 || head.polygons > rest / 8)
            return lines_.error(fmt::format(
                "the file is too short for {} vertices and {} polygons; it is cut off or its "
                "counts are wrong",
                head.vertices, head.polygons));
        return head;
    }

    [[nodiscard]] Status check_keyword(std::string_view keyword) const {
        if (!keyword.ends_with("OFF"))
            return lines_.error("an OFF file begins with the word OFF, not with " +
                                quoted(keyword));
        if (prefixes_of(keyword).known) return {};
        return unsupported(quoted(keyword) + " files are not read; write plain OFF, with x, y, z");
    }

    [[nodiscard]] Error unsupported(std::string message) const {
        return {ErrorCode::Unsupported, std::move(message), lines_.error("").where};
    }

    /// Line `k` of `count`.
    Result<Words> next_line(std::int64_t k, std::int64_t count, const char* what) {
        Words words("");
        if (lines_.next(words)) return words;
        return lines_.error(fmt::format("ends after {} of {} {}; it is cut off", k, count, what));
    }

    /// Whether colours have three or four numbers is seen on the line of the first vertex.
    Status set_parts(std::string_view keyword, Words words) {
        const OffPrefixes prefixes = prefixes_of(keyword);
        parts_.normal = prefixes.normal ? 3 : 0;
        parts_.uv = prefixes.uv ? 2 : 0;
        if (!prefixes.colour) return {};
        int count = 0;
        for (; !words.empty() && count < 16; words.next()) ++count;
        parts_.colour = count - 3 - parts_.count();
        if (parts_.colour == 3 || parts_.colour == 4) return {};
        return lines_.error(
            fmt::format("a colour of a {} file has 3 or 4 numbers; this line has {} numbers in all",
                        keyword, count));
    }

    Status read_vertex(Words words) {
        std::array<double, 3> vertex{};
        RELIEF_CHECK(read_numbers(words, lines_, "vertex", vertex));
        mesh_.vertices.push_back(vertex);
        RELIEF_CHECK(read_part(words, "normal", parts_.normal, normals_));
        if (parts_.colour > 0) note_colour(words);
        RELIEF_CHECK(read_part(words, "colour", parts_.colour, colours_));
        return read_part(words, "texture place", parts_.uv, uv_);
    }

    Status read_part(Words& words, std::string_view element, int count,
                     std::vector<double>& values) {
        std::array<double, 4> part{};
        const auto numbers = std::span(part).first(static_cast<std::size_t>(count));
        RELIEF_CHECK(read_numbers(words, lines_, element, numbers));
        values.insert(values.end(), numbers.begin(), numbers.end());
        return {};
    }

    /// Bytes are written without a point; 1 may be the least or the largest value otherwise.
    void note_colour(Words words) {
        for (int k = 0; k < parts_.colour; ++k) {
            int number = -1;
            if (!parse_number(words.next(), number) || number < 0 || number > 255)
                whole_colours_ = false;
        }
    }

    Status read_polygon(Words words) {
        std::int64_t size = 0;
        if (!parse_number(words.next(), size) || size < 3)
            return lines_.error("a polygon begins with the number of its corners, at least 3");
        for (std::int64_t k = 0; k < size; ++k) {
            const std::string_view word = words.next();
            std::int64_t vertex = 0;
            if (!parse_number(word, vertex))
                return lines_.error(
                    fmt::format("a polygon of {} corners needs as many numbers of vertices, not {}",
                                size, quoted(word)));
            if (vertex < 0 || vertex >= static_cast<std::int64_t>(mesh_.vertices.size()))
                return lines_.error(
                    fmt::format("index_out_of_range: a polygon names vertex {} of {}; vertices "
                                "count from 0",
                                vertex, mesh_.vertices.size()));
            mesh_.corners.push_back(static_cast<std::int32_t>(vertex));
        }
        if (static_cast<std::int64_t>(mesh_.corners.size()) > kMostElements)
            return lines_.error(kTooMany);
        mesh_.offsets.push_back(static_cast<std::int64_t>(mesh_.corners.size()));
        return {};
    }

    void add_attribute(const char* name, int components, SampleType type,
                       std::vector<double>& values) {
        if (components > 0)
            mesh_.attributes.push_back({name, components, type, std::move(values), {}});
    }

    Lines lines_;
    PolygonMesh mesh_;
    OffParts parts_;
    std::vector<double> uv_;
    std::vector<double> colours_;
    std::vector<double> normals_;
    bool whole_colours_ = true;
};

/// An attribute that a line of a vertex can hold; null otherwise.
const MeshAttribute* of_vertices(const PolygonMesh& mesh, std::string_view name, int most) {
    const MeshAttribute* attribute = mesh.attribute(name);
    return attribute && !attribute->face_varying() && attribute->components <= most ? attribute
                                                                                    : nullptr;
}

/// Floats are written with a point, which tells them from bytes.
void append_colour(std::string& text, const MeshAttribute& colour, std::int64_t v) {
    const double largest = is_integer(colour.type) ? sample_range(colour.type).second : 1;
    const auto out = std::back_inserter(text);
    for (int k = 0; k < colour.components; ++k) {
        const double value = colour.element(v)[k];
        if (colour.type == SampleType::UInt8) {
            fmt::format_to(out, " {}", value);
        } else {
            fmt::format_to(out, " {:#}", value / largest);
        }
    }
}

void append_element(std::string& text, const MeshAttribute& attribute, std::int64_t v) {
    for (int k = 0; k < attribute.components; ++k)
        fmt::format_to(std::back_inserter(text), " {}", attribute.element(v)[k]);
}

}  // namespace

bool is_off_keyword(std::string_view word) {
    return prefixes_of(word).known;
}

EncodedMesh encode_off(const PolygonMesh& mesh) {
    const MeshAttribute* uv = of_vertices(mesh, "uv", 2);
    const MeshAttribute* colour = of_vertices(mesh, "colour", 4);
    const MeshAttribute* normal = of_vertices(mesh, "normal", 3);
    EncodedMesh file;
    std::string& text = file.bytes;
    const auto out = std::back_inserter(text);
    fmt::format_to(out, "{}{}{}OFF\n{} {} 0\n", uv ? "ST" : "", colour ? "C" : "",
                   normal ? "N" : "", mesh.vertices.size(), mesh.polygon_count());
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const auto& [x, y, z] = mesh.vertices[v];
        fmt::format_to(out, "{} {} {}", x, y, z);
        const auto number = static_cast<std::int64_t>(v);
        if (normal) append_element(text, *normal, number);
        if (colour) append_colour(text, *colour, number);
        if (uv) append_element(text, *uv, number);
        text += '\n';
    }
    for (std::int64_t k = 0; k < mesh.polygon_count(); ++k) {
        fmt::format_to(out, "{}", mesh.polygon(k).size());
        for (const std::int32_t v : mesh.polygon(k)) fmt::format_to(out, " {}", v);
        text += '\n';
    }
    for (const MeshAttribute& attribute : mesh.attributes)
        if (&attribute != uv && &attribute != colour && &attribute != normal)
            file.left_out.push_back(attribute.name);
    for (std::string& name : extras_of(mesh)) file.left_out.push_back(std::move(name));
    return file;
}

}  // namespace detail

Result<PolygonMesh> parse_off(std::span<const std::uint8_t> bytes, const std::string& name) {
    return detail::OffReader(detail::text_of(bytes), name).read();
}

}  // namespace relief::io
