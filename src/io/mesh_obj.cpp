#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>

#include "io/mesh_formats.h"
#include "io/text_lines.h"

namespace relief::io {

namespace detail {

namespace {

/// Numbers of elements that lines name, perhaps before these elements come.
class References {
  public:
    explicit References(const char* element) : element_(element) {}

    /// `number` counts from 1, or back from the last of `count` elements so far. Returns it from 0.
    Result<std::int32_t> resolve(std::int64_t number, std::size_t count, const Lines& lines) {
        const auto so_far = static_cast<std::int64_t>(count);
        if (number == 0 || number < -so_far || number > kMostElements)
            return error(number, count, lines, lines.number());
        if (number > highest_) {
            highest_ = number;
            line_ = lines.number();
        }
        return static_cast<std::int32_t>(number > 0 ? number - 1 : so_far + number);
    }

    /// Requires: all elements are there.
    [[nodiscard]] Status check(std::size_t count, const Lines& lines) const {
        if (highest_ <= static_cast<std::int64_t>(count)) return {};
        return error(highest_, count, lines, line_);
    }

  private:
    Error error(std::int64_t number, std::size_t count, const Lines& lines,
                std::int64_t line) const {
        return lines.error_at(
            line, fmt::format("index_out_of_range: a line names {} {} of {}; they count from 1",
                              element_, number, count));
    }

    const char* element_;
    std::int64_t highest_ = 0;
    std::int64_t line_ = 0;
};

/// Lines vt or vn, and the corners that name them.
class CornerElements {
  public:
    CornerElements(const char* name, const char* element) : name_(name), references_(element) {}

    /// Requires: three numbers, of which `components` stand on the line.
    void add(std::span<const double> numbers, int components) {
        values_.insert(values_.end(), numbers.begin(), numbers.end());
        components_ = std::max(components_, components);
    }

    /// `word` is empty at a corner without an element.
    Status add_corner(std::string_view word, const Lines& lines) {
        std::int32_t element = -1;
        if (!word.empty()) {
            std::int64_t number = 0;
            if (!parse_number(word, number))
                return lines.error("a corner of a face is v, v/vt, v//vn or v/vt/vn, not " +
                                   quoted(word) + " for one of them");
            RELIEF_TRY(element, references_.resolve(number, values_.size() / 3, lines));
        }
        corners_.push_back(element);
        return {};
    }

    /// A polygon has elements at all of its corners, or they are left out.
    void end_polygon(std::size_t size) {
        const auto first = corners_.end() - static_cast<std::ptrdiff_t>(size);
        if (std::find(first, corners_.end(), -1) != corners_.end())
            std::fill(first, corners_.end(), -1);
        used_ = used_ || corners_.back() >= 0;
    }

    Status finish(PolygonMesh& mesh, const Lines& lines) {
        RELIEF_CHECK(references_.check(values_.size() / 3, lines));
        const bool of_vertices =
            values_.size() == 3 * mesh.vertices.size() && corners_ == mesh.corners;
        if (values_.empty() || (!used_ && !of_vertices)) return {};
        if (components_ == 2) drop_third();
        if (of_vertices) corners_.clear();
        mesh.attributes.push_back(
            {name_, components_, SampleType::Float64, std::move(values_), std::move(corners_)});
        return {};
    }

  private:
    void drop_third() {
        const std::size_t count = values_.size() / 3;
        for (std::size_t k = 0; k < count; ++k) {
            values_[2 * k] = values_[3 * k];
            values_[2 * k + 1] = values_[3 * k + 1];
        }
        values_.resize(2 * count);
    }

    const char* name_;
    References references_;
    std::vector<double> values_;  ///< three an element
    int components_ = 2;
    std::vector<std::int32_t> corners_;
    bool used_ = false;
};

/// Colours that only some lines of vertices may have.
class VertexColours {
  public:
    /// Three or four numbers of the vertex that was read last, which is number `vertices` - 1.
    void add(std::span<const double> numbers, std::size_t vertices) {
        values_.resize(4 * (vertices - 1), kWhite);
        values_.insert(values_.end(), numbers.begin(), numbers.end());
        values_.resize(4 * vertices, kWhite);
        components_ = std::max(components_, static_cast<int>(numbers.size()));
    }

    void finish(PolygonMesh& mesh) {
        if (components_ == 0) return;
        values_.resize(4 * mesh.vertices.size(), kWhite);
        MeshAttribute colour{"colour", components_, type()};
        const double white = colour.type == SampleType::UInt8 ? 255 : 1;
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
            for (std::size_t k = 0; k < static_cast<std::size_t>(components_); ++k) {
                const double value = values_[4 * v + k];
                colour.values.push_back(value == kWhite ? white : value);
            }
        mesh.attributes.push_back(std::move(colour));
    }

  private:
    static constexpr double kWhite = HUGE_VAL;  ///< no colour in a file is infinite

    /// Bytes show by whole numbers beyond 1.
    [[nodiscard]] SampleType type() const {
        bool whole = true;
        bool beyond = false;
        for (const double value : values_) {
            if (value == kWhite) continue;
            whole = whole && value >= 0 && value <= 255 && value == std::floor(value);
            beyond = beyond || value > 1;
        }
        return whole && beyond ? SampleType::UInt8 : SampleType::Float64;
    }

    std::vector<double> values_;  ///< four a vertex
    int components_ = 0;
};

/// What a statement such as usemtl says of the faces that follow it.
class Statement {
  public:
    explicit Statement(std::string keyword) : labels_{std::move(keyword)} {}

    [[nodiscard]] const std::string& keyword() const { return labels_.keyword; }

    /// `name` outlives this object.
    void set(std::string_view name) {
        const bool none = keyword() == "s" && (name == "off" || name == "0");
        name_ = none ? std::string_view() : name;
        is_known_ = false;
    }

    /// Face `number`; names become labels with the first face that has them.
    void add_face(std::int64_t number) {
        if (!is_known_) current_ = number_of(name_);
        is_known_ = true;
        if (labels_.names.empty()) return;
        labels_.of_face.resize(static_cast<std::size_t>(number), -1);
        labels_.of_face.push_back(current_);
    }

    void finish(PolygonMesh& mesh) {
        if (!labels_.names.empty()) mesh.labels.push_back(std::move(labels_));
    }

  private:
    std::int32_t number_of(std::string_view name) {
        if (name.empty()) return -1;
        const auto next = static_cast<std::int32_t>(labels_.names.size());
        const auto [place, is_new] = numbers_.try_emplace(name, next);
        if (is_new) labels_.names.emplace_back(name);
        return place->second;
    }

    FaceLabels labels_;
    std::map<std::string_view, std::int32_t> numbers_;
    std::string_view name_;  ///< of the next faces; empty: none
    std::int32_t current_ = -1;
    bool is_known_ = true;  ///< current_ is the number of name_
};

/// The arguments of a line `t name ints/floats/strings ..`; strings are left out.
struct Tag {
    std::vector<std::int32_t> vertices;
    std::vector<double> sharpness;

    /// One for all, or one for each.
    [[nodiscard]] double sharpness_of(std::size_t k) const {
        return sharpness.size() == 1 ? sharpness[0] : sharpness[k];
    }
};

class ObjReader {
  public:
    ObjReader(std::string_view text, const std::string& name) : lines_(text, name, Syntax::Obj) {}

    Result<PolygonMesh> read() {
        for (Words words(""); lines_.next(words);) {
            const std::string_view keyword = words.next();
            RELIEF_CHECK(read_line(keyword, words));
        }
        RELIEF_CHECK(vertices_.check(mesh_.vertices.size(), lines_));
        RELIEF_CHECK(uv_.finish(mesh_, lines_));
        colours_.finish(mesh_);
        RELIEF_CHECK(normals_.finish(mesh_, lines_));
        for (Statement& statement : statements_) statement.finish(mesh_);
        return std::move(mesh_);
    }

  private:
    Status read_line(std::string_view keyword, Words words) {
        if (keyword == "v") return read_vertex(words);
        if (keyword == "f") return read_face(words);
        if (keyword == "vt") return read_texture_place(words);
        if (keyword == "vn") return read_normal(words);
        if (keyword == "t") return read_tag(words);
        const std::string_view name = name_of(words);
        if (keyword == "mtllib" && !name.empty()) mesh_.libraries.emplace_back(name);
        for (Statement& statement : statements_)
            if (keyword == statement.keyword()) statement.set(name);
        return {};
    }

    /// All that is left of a line, without a backslash that would continue it elsewhere.
    static std::string_view name_of(const Words& words) {
        const std::string_view rest = words.rest();
        return rest.substr(0, rest.find_last_not_of("\\ \t\r\v\f") + 1);
    }

    Status read_vertex(Words words) {
        if (static_cast<std::int64_t>(mesh_.vertices.size()) == kMostElements)
            return lines_.error(kTooMany);
        std::array<double, 3> vertex{};
        RELIEF_CHECK(read_numbers(words, lines_, "vertex", vertex));
        mesh_.vertices.push_back(vertex);
        std::array<double, 4> more{};
        std::size_t count = 0;
        for (; count < more.size() && !words.empty(); ++count)
            RELIEF_CHECK(read_numbers(words, lines_, "colour", std::span(more).subspan(count, 1)));
        // One number is a weight, which polygons do not have.
        if (count >= 3) colours_.add(std::span(more).first(count), mesh_.vertices.size());
        return {};
    }

    Status read_texture_place(Words words) {
        std::array<double, 3> place{};
        std::size_t count = 0;
        do {
            RELIEF_CHECK(
                read_numbers(words, lines_, "texture place", std::span(place).subspan(count, 1)));
            ++count;
        } while (count < place.size() && !words.empty());
        uv_.add(place, static_cast<int>(count));
        return {};
    }

    Status read_normal(Words words) {
        std::array<double, 3> normal{};
        RELIEF_CHECK(read_numbers(words, lines_, "normal", normal));
        normals_.add(normal, 3);
        return {};
    }

    Status read_face(Words words) {
        const std::size_t before = mesh_.corners.size();
        while (!words.empty()) RELIEF_CHECK(read_corner(words.next()));
        const std::size_t size = mesh_.corners.size() - before;
        if (size < 3) return lines_.error("a face needs at least 3 corners");
        if (static_cast<std::int64_t>(mesh_.corners.size()) > kMostElements)
            return lines_.error(kTooMany);
        for (Statement& statement : statements_) statement.add_face(mesh_.polygon_count());
        mesh_.offsets.push_back(static_cast<std::int64_t>(mesh_.corners.size()));
        uv_.end_polygon(size);
        normals_.end_polygon(size);
        return {};
    }

    /// v, v/vt, v//vn or v/vt/vn.
    Status read_corner(std::string_view word) {
        std::array<std::string_view, 3> parts;
        std::size_t count = 0;
        std::string_view rest = word;
        for (bool more = true; more && count < parts.size(); ++count) {
            parts[count] = rest.substr(0, rest.find('/'));
            more = parts[count].size() < rest.size();
            rest.remove_prefix(parts[count].size() + (more ? 1 : 0));
        }
        std::int64_t vertex = 0;
        const bool ends_empty = count > 1 && parts[count - 1].empty();
        if (!rest.empty() || ends_empty || !parse_number(parts[0], vertex))
            return lines_.error("a corner of a face is v, v/vt, v//vn or v/vt/vn, not " +
                                quoted(word));
        RELIEF_TRY(const std::int32_t resolved,
                   vertices_.resolve(vertex, mesh_.vertices.size(), lines_));
        mesh_.corners.push_back(resolved);
        RELIEF_CHECK(uv_.add_corner(parts[1], lines_));
        return normals_.add_corner(parts[2], lines_);
    }

    Status read_tag(Words words) {
        const std::string_view name = words.next();
        if (name != "crease" && name != "corner") return {};
        const std::size_t ends = name == "crease" ? 1 : 0;  // a chain has one edge less
        RELIEF_TRY(const Tag tag, read_arguments(words));
        if (tag.vertices.size() <= ends ||
            (tag.sharpness.size() != 1 && tag.sharpness.size() != tag.vertices.size() - ends))
            return lines_.error(
                "a tag is t crease 2/1/0 a b sharpness, or t corner 1/1/0 v sharpness, with "
                "vertices from 0");
        for (std::size_t k = 0; k + ends < tag.vertices.size(); ++k) {
            const double sharpness = sharpness_in_mesh(tag.sharpness_of(k));
            const std::int32_t first = tag.vertices[k];
            const std::int32_t last = tag.vertices[k + ends];
            if (sharpness <= 0 || (ends == 1 && first == last)) continue;
            if (ends == 1) {
                mesh_.creases.push_back({first, last, sharpness});
            } else {
                mesh_.sharp_vertices.push_back({first, sharpness});
            }
        }
        return {};
    }

    Result<Tag> read_arguments(Words& words) {
        std::array<std::int64_t, 3> counts{};
        std::string_view sizes = words.next();
        for (std::int64_t& count : counts) {
            const std::string_view part = sizes.substr(0, sizes.find('/'));
            if (!parse_number(part, count) || count < 0)
                return lines_.error("a tag has the numbers of its arguments, as in 2/1/0, here");
            sizes.remove_prefix(std::min(part.size() + 1, sizes.size()));
        }
        Tag tag;
        for (std::int64_t k = 0; k < counts[0]; ++k) {
            const std::string_view word = words.next();
            std::int64_t vertex = 0;
            if (!parse_number(word, vertex))
                return lines_.error("a tag needs as many vertices as it says, not " + quoted(word));
            if (vertex < 0 || vertex >= kMostElements)
                return lines_.error("index_out_of_range: vertices of tags count from 0, not to " +
                                    quoted(word));
            RELIEF_TRY(const std::int32_t resolved,
                       vertices_.resolve(vertex + 1, mesh_.vertices.size(), lines_));
            tag.vertices.push_back(resolved);
        }
        for (std::int64_t k = 0; k < counts[1]; ++k) {
            double sharpness = 0;
            if (!parse_number(words.next(), sharpness) || std::isnan(sharpness))
                return lines_.error("a tag needs as many numbers of sharpness as it says");
            tag.sharpness.push_back(sharpness);
        }
        return tag;
    }

    Lines lines_;
    PolygonMesh mesh_;
    References vertices_{"vertex"};
    CornerElements uv_{"uv", "texture place"};
    CornerElements normals_{"normal", "normal"};
    VertexColours colours_;
    std::array<Statement, 4> statements_ = {Statement("o"), Statement("g"), Statement("usemtl"),
                                            Statement("s")};
};

void append_numbers(std::string& text, const double* numbers, int count, double scale = 1) {
    for (int k = 0; k < count; ++k)
        fmt::format_to(std::back_inserter(text), " {}", numbers[k] / scale);
}

void append_vertices(std::string& text, const PolygonMesh& mesh, const MeshAttribute* colour) {
    const double scale = colour && is_integer(colour->type) ? sample_range(colour->type).second : 1;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        text += 'v';
        append_numbers(text, mesh.vertices[v].data(), 3);
        if (colour)
            append_numbers(text, colour->element(static_cast<std::int64_t>(v)), colour->components,
                           scale);
        text += '\n';
    }
}

void append_elements(std::string& text, const char* keyword, const MeshAttribute* attribute) {
    for (std::int64_t k = 0; attribute && k < attribute->element_count(); ++k) {
        text += keyword;
        append_numbers(text, attribute->element(k), attribute->components);
        text += '\n';
    }
}

/// The element at a corner, from 1; 0: none.
std::int64_t element_at(const MeshAttribute* attribute, const PolygonMesh& mesh,
                        std::size_t corner) {
    if (!attribute) return 0;
    const auto& corners = attribute->face_varying() ? attribute->corners : mesh.corners;
    return std::int64_t{corners[corner]} + 1;
}

void append_corner(std::string& text, const PolygonMesh& mesh, std::size_t corner,
                   const MeshAttribute* uv, const MeshAttribute* normal) {
    const auto out = std::back_inserter(text);
    fmt::format_to(out, " {}", std::int64_t{mesh.corners[corner]} + 1);
    const std::int64_t vt = element_at(uv, mesh, corner);
    const std::int64_t vn = element_at(normal, mesh, corner);
    if (vt > 0) fmt::format_to(out, "/{}", vt);
    if (vn > 0) fmt::format_to(out, "{}/{}", vt > 0 ? "" : "/", vn);
}

void append_faces(std::string& text, const PolygonMesh& mesh) {
    const MeshAttribute* uv = mesh.attribute("uv");
    const MeshAttribute* normal = mesh.attribute("normal");
    std::vector<std::int32_t> current(mesh.labels.size(), -1);
    for (std::size_t k = 0; k + 1 < mesh.offsets.size(); ++k) {
        for (std::size_t j = 0; j < mesh.labels.size(); ++j) {
            const FaceLabels& labels = mesh.labels[j];
            const std::int32_t label = labels.of_face[k];
            if (label == current[j]) continue;
            current[j] = label;
            text += labels.keyword;
            if (label >= 0) {
                text += ' ' + labels.names[static_cast<std::size_t>(label)];
            } else if (labels.keyword == "s") {
                text += " off";
            }
            text += '\n';
        }
        text += 'f';
        for (auto c = static_cast<std::size_t>(mesh.offsets[k]);
             c < static_cast<std::size_t>(mesh.offsets[k + 1]); ++c)
            append_corner(text, mesh, c, uv, normal);
        text += '\n';
    }
}

}  // namespace

EncodedMesh encode_obj(const PolygonMesh& mesh) {
    const MeshAttribute* colour = mesh.attribute("colour");
    if (colour && colour->face_varying()) colour = nullptr;
    EncodedMesh file;
    std::string& text = file.bytes;
    const auto out = std::back_inserter(text);
    for (const std::string& library : mesh.libraries) fmt::format_to(out, "mtllib {}\n", library);
    append_vertices(text, mesh, colour);
    append_elements(text, "vt", mesh.attribute("uv"));
    append_elements(text, "vn", mesh.attribute("normal"));
    append_faces(text, mesh);
    for (const CreaseEdge& crease : mesh.creases)
        fmt::format_to(out, "t crease 2/1/0 {} {} {}\n", crease.a, crease.b,
                       sharpness_in_file(crease.sharpness));
    for (const SharpVertex& sharp : mesh.sharp_vertices)
        fmt::format_to(out, "t corner 1/1/0 {} {}\n", sharp.vertex,
                       sharpness_in_file(sharp.sharpness));
    for (const MeshAttribute& attribute : mesh.attributes)
        if (&attribute != colour && attribute.name != "uv" && attribute.name != "normal")
            file.left_out.push_back(attribute.name);
    return file;
}

}  // namespace detail

Result<PolygonMesh> parse_obj(std::span<const std::uint8_t> bytes, const std::string& name) {
    return detail::ObjReader(detail::text_of(bytes), name).read();
}

}  // namespace relief::io
