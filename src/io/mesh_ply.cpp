#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "io/mesh_formats.h"
#include "io/ply.h"
#include "io/text_lines.h"
#include "io/weld.h"

namespace relief::io {

namespace detail {

namespace {

using ply::Element;
using ply::Property;
using ply::Type;
using ply::Use;

/// The rows of the elements, number by number.
class Body {
  public:
    Body() = default;
    Body(const Body&) = delete;
    Body& operator=(const Body&) = delete;
    virtual ~Body() = default;

    /// What may fit into the rest of the file, at most.
    [[nodiscard]] virtual std::int64_t most_rows(const Element& element) = 0;
    /// False at the end of the file.
    virtual bool begin_row() = 0;
    /// False if there is no number of this type.
    virtual bool read(Type type, double& number) = 0;
    /// False if the row has more.
    [[nodiscard]] virtual bool at_end_of_row() const = 0;
    [[nodiscard]] virtual bool at_end() = 0;
    /// An error of the number that was read last.
    [[nodiscard]] virtual Error error(std::string message) const = 0;
};

class TextBody final : public Body {
  public:
    explicit TextBody(const Lines& lines) : lines_(lines) {}

    [[nodiscard]] std::int64_t most_rows(const Element& element) override {
        // Each number takes a digit and what separates it from the next.
        const std::size_t shortest = 2 * element.properties.size();
        return static_cast<std::int64_t>((lines_.bytes_left() + 1) / shortest);
    }
    bool begin_row() override { return lines_.next(words_); }
    bool read(Type type, double& number) override {
        const std::string_view word = words_.next();
        if (!ply::is_integer(type)) return parse_number(word, number);
        std::int64_t whole = 0;
        if (!parse_number(word, whole)) return false;
        number = static_cast<double>(whole);
        const auto [low, high] = ply::range(type);
        return number >= low && number <= high;
    }
    [[nodiscard]] bool at_end_of_row() const override { return words_.empty(); }
    [[nodiscard]] bool at_end() override { return !lines_.next(words_); }
    [[nodiscard]] Error error(std::string message) const override {
        return lines_.error(std::move(message));
    }

  private:
    Lines lines_;
    Words words_{""};
};

class BinaryBody final : public Body {
  public:
    BinaryBody(std::span<const std::uint8_t> bytes, std::size_t at, bool big,
               const std::string& name)
        : bytes_(bytes), at_(at), last_(at), big_(big), name_(name) {}

    [[nodiscard]] std::int64_t most_rows(const Element& element) override {
        last_ = at_;
        std::size_t shortest = 0;
        for (const Property& property : element.properties)
            shortest += ply::size_of(property.count_type.value_or(property.type));
        return static_cast<std::int64_t>((bytes_.size() - at_) / shortest);
    }
    bool begin_row() override { return at_ < bytes_.size(); }
    bool read(Type type, double& number) override {
        last_ = at_;
        if (bytes_.size() - at_ < ply::size_of(type)) return false;
        number = ply::load(type, bytes_.data() + at_, big_);
        at_ += ply::size_of(type);
        return true;
    }
    [[nodiscard]] bool at_end_of_row() const override { return true; }
    [[nodiscard]] bool at_end() override {
        last_ = at_;
        return at_ == bytes_.size();
    }
    [[nodiscard]] Error error(std::string message) const override {
        return {ErrorCode::BadInput, std::move(message), fmt::format("{}, byte {}", name_, last_)};
    }

  private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_;
    std::size_t last_;
    bool big_;
    const std::string& name_;
};

class PlyReader {
  public:
    PlyReader(std::span<const std::uint8_t> bytes, const std::string& name)
        : bytes_(bytes), name_(name) {}

    Result<PolygonMesh> read() {
        Lines lines(text_of(bytes_), name_, Syntax::Plain);
        RELIEF_TRY(head_, ply::read_head(lines));
        RELIEF_CHECK(choose(lines));
        const std::size_t start = bytes_.size() - lines.bytes_left();
        std::unique_ptr<Body> body;
        if (head_.encoding == ply::Encoding::Ascii) {
            body = std::make_unique<TextBody>(lines);
        } else {
            const bool big = head_.encoding == ply::Encoding::BinaryBigEndian;
            body = std::make_unique<BinaryBody>(bytes_, start, big, name_);
        }
        for (Element& element : head_.elements) RELIEF_CHECK(read_rows(*body, element));
        if (!body->at_end())
            return body->error("there is more than the elements that the head lists");
        assemble();
        return std::move(mesh_);
    }

  private:
    struct VertexAttribute {
        const ply::VertexNames* names;
        std::vector<Property*> columns;
    };
    struct CornerAttribute {
        const ply::CornerNames* names;
        Property* list;
        std::size_t components = 0;
    };

    /// Marks what is kept. Errors: vertices or faces can not be found.
    Status choose(const Lines& lines) {
        Element* vertices = head_.find("vertex");
        for (std::size_t k = 0; k < 3; ++k) {
            places_[k] = vertices ? vertices->find(ply::kPlaces[k]) : nullptr;
            if (!places_[k] || places_[k]->count_type)
                return lines.error("a PLY file needs an element vertex with properties x, y, z");
            places_[k]->use = Use::Number;
        }
        if (vertices->count > kMostElements) return lines.error(kTooMany);
        vertex_count_ = vertices->count;
        for (const ply::VertexNames& names : ply::kVertexAttributes)
            choose_attribute(*vertices, names);
        if (Element* faces = head_.find("face")) RELIEF_CHECK(choose_faces(*faces, lines));
        if (Element* creases = head_.find(ply::kCrease)) {
            for (std::size_t k = 0; k < 2; ++k)
                creases_[k] = choose_index(*creases, ply::kCreaseEnds[k], 0, vertex_count_);
            creases_[2] = choose_number(*creases, ply::kSharpness);
        }
        if (Element* sharp = head_.find(ply::kSharpVertex)) {
            sharp_[0] = choose_index(*sharp, ply::kCreaseEnds[0], 0, vertex_count_);
            sharp_[1] = choose_number(*sharp, ply::kSharpness);
        }
        return {};
    }

    Status choose_faces(Element& faces, const Lines& lines) {
        polygons_ = faces.find("vertex_indices");
        if (!polygons_) polygons_ = faces.find("vertex_index");
        if (!polygons_ || !polygons_->count_type)
            return lines.error("the element face needs a list of vertex_indices");
        if (faces.count > kMostElements) return lines.error(kTooMany);
        faces_ = &faces;
        polygons_->use = Use::Index;
        polygons_->limits = {0, static_cast<double>(vertex_count_ - 1)};
        for (const ply::CornerNames& names : ply::kCornerAttributes)
            if (Property* list = faces.find(names.list); list && list->count_type) {
                list->use = Use::Number;
                corner_attributes_.push_back({&names, list});
            }
        for (std::size_t k = 0; k < labels_.size(); ++k)
            if (const auto count = static_cast<std::int64_t>(head_.labels[k].size()); count > 0)
                labels_[k] = choose_index(faces, ply::kLabels[k].property, -1, count);
        return {};
    }

    void choose_attribute(Element& vertices, const ply::VertexNames& names) {
        VertexAttribute attribute{&names, {}};
        for (const char* name : names.properties) {
            Property* column = name ? vertices.find(name) : nullptr;
            if (!column || column->count_type) break;
            attribute.columns.push_back(column);
        }
        const bool taken =
            std::any_of(vertex_attributes_.begin(), vertex_attributes_.end(),
                        [&](const VertexAttribute& other) {
                            return std::string_view(other.names->attribute) == names.attribute;
                        });
        if (taken || attribute.columns.size() < names.least) return;
        for (Property* column : attribute.columns) column->use = Use::Number;
        vertex_attributes_.push_back(std::move(attribute));
    }

    static Property* choose_number(Element& element, const char* name) {
        Property* property = element.find(name);
        if (!property || property->count_type) return nullptr;
        property->use = Use::Number;
        return property;
    }

    static Property* choose_index(Element& element, const char* name, double low,
                                  std::int64_t count) {
        Property* property = choose_number(element, name);
        if (!property) return nullptr;
        property->use = Use::Index;
        property->limits = {low, static_cast<double>(count) - 1};
        return property;
    }

    Status read_rows(Body& body, Element& element) {
        if (element.properties.empty()) return {};
        if (element.count > body.most_rows(element))
            return body.error(fmt::format(
                "the file is too short for {} rows of element {}; it is cut off or its counts are "
                "wrong",
                element.count, quoted(element.name)));
        for (std::int64_t row = 0; row < element.count; ++row) {
            if (!body.begin_row())
                return body.error(
                    fmt::format("ends after {} of {} rows of element {}; it is cut off", row,
                                element.count, quoted(element.name)));
            for (Property& property : element.properties)
                RELIEF_CHECK(read_property(body, element, property));
            if (!body.at_end_of_row())
                return body.error("the row has more numbers than the head says");
            if (&element == faces_) RELIEF_CHECK(check_face(body));
        }
        return {};
    }

    Status read_property(Body& body, const Element& element, Property& property) {
        double count = 1;
        if (property.count_type) {
            if (!body.read(*property.count_type, count) || count < 0)
                return missing(body, element, property);
            if (property.use != Use::Skipped)
                property.sizes.push_back(static_cast<std::int64_t>(count));
        }
        for (auto k = static_cast<std::int64_t>(count); k > 0; --k) {
            double number = 0;
            if (!body.read(property.type, number)) return missing(body, element, property);
            if (property.use == Use::Skipped) continue;
            RELIEF_CHECK(check_number(body, element, property, number));
            property.values.push_back(number);
        }
        return {};
    }

    static Error missing(const Body& body, const Element& element, const Property& property) {
        return body.error(
            fmt::format("a number for property {} of element {} is missing or is "
                        "none of its type; the file is cut off or damaged",
                        quoted(property.name), quoted(element.name)));
    }

    [[nodiscard]] Status check_number(const Body& body, const Element& element,
                                      const Property& property, double number) const {
        if (property.use == Use::Number) {
            if (std::isfinite(number) || property.name == ply::kSharpness) return {};
            const bool place =
                std::find(places_.begin(), places_.end(), &property) != places_.end();
            return body.error(
                fmt::format("non_finite_{}: {} is not a finite number; remove or "
                            "repair it",
                            place ? "vertex" : "value", quoted(property.name)));
        }
        if (number >= property.limits.first && number <= property.limits.second &&
            number == std::floor(number))
            return {};
        return body.error(fmt::format(
            "index_out_of_range: {} of element {} names number {}, but "
            "there are {}, from 0",
            quoted(property.name), quoted(element.name), number, property.limits.second + 1));
    }

    /// The lists of the face that was read last fit to one another.
    Status check_face(const Body& body) {
        const std::int64_t size = polygons_->sizes.back();
        if (size < 3) return body.error("a polygon needs at least 3 corners");
        if (static_cast<std::int64_t>(polygons_->values.size()) > kMostElements)
            return body.error(kTooMany);
        for (CornerAttribute& attribute : corner_attributes_) {
            const std::int64_t numbers = attribute.list->sizes.back();
            if (numbers == 0) continue;
            const auto components = static_cast<std::size_t>(numbers / size);
            if (attribute.components == 0) attribute.components = components;
            if (numbers % size != 0 || components != attribute.components ||
                components < attribute.names->least || components > attribute.names->most)
                return body.error(fmt::format("{} numbers are not a list of {} for {} corners",
                                              numbers, quoted(attribute.list->name), size));
        }
        return {};
    }

    void assemble() {
        mesh_.vertices.reserve(places_[0]->values.size());
        for (std::size_t v = 0; v < places_[0]->values.size(); ++v)
            mesh_.vertices.push_back(
                {places_[0]->values[v], places_[1]->values[v], places_[2]->values[v]});
        if (polygons_) {
            mesh_.corners.assign(polygons_->values.begin(), polygons_->values.end());
            for (const std::int64_t size : polygons_->sizes)
                mesh_.offsets.push_back(mesh_.offsets.back() + size);
        }
        for (const ply::CornerNames& names : ply::kCornerAttributes)
            assemble_attribute(names.attribute);
        for (std::size_t k = 0; k < labels_.size(); ++k)
            if (const Property* column = labels_[k])
                mesh_.labels.push_back(
                    {ply::kLabels[k].keyword, std::move(head_.labels[k]),
                     std::vector<std::int32_t>(column->values.begin(), column->values.end())});
        mesh_.libraries = std::move(head_.libraries);
        assemble_creases();
    }

    /// Corners go before vertices, because they can say more.
    void assemble_attribute(std::string_view name) {
        for (const CornerAttribute& attribute : corner_attributes_)
            if (attribute.names->attribute == name && attribute.components > 0) {
                mesh_.attributes.push_back(of_corners(attribute));
                return;
            }
        for (const VertexAttribute& attribute : vertex_attributes_)
            if (attribute.names->attribute == name)
                mesh_.attributes.push_back(of_vertices(attribute));
    }

    static MeshAttribute of_vertices(const VertexAttribute& source) {
        MeshAttribute attribute{source.names->attribute, static_cast<int>(source.columns.size()),
                                ply::sample_type(source.columns[0]->type)};
        for (const Property* column : source.columns)
            if (column->type != source.columns[0]->type) attribute.type = SampleType::Float64;
        const std::size_t count = source.columns[0]->values.size();
        for (std::size_t v = 0; v < count; ++v)
            for (const Property* column : source.columns)
                attribute.values.push_back(
                    stored_value(column->values[v], attribute.type, std::nullopt));
        return attribute;
    }

    /// Equal elements become one.
    MeshAttribute of_corners(const CornerAttribute& source) {
        MeshAttribute attribute{source.names->attribute, static_cast<int>(source.components),
                                ply::sample_type(source.list->type)};
        std::vector<double>& values = source.list->values;
        for (double& value : values) value = stored_value(value, attribute.type, std::nullopt);
        const Welded welded = weld(values, source.components);
        for (const std::int32_t first : welded.firsts) {
            const auto* element =
                values.data() + static_cast<std::size_t>(first) * source.components;
            attribute.values.insert(attribute.values.end(), element, element + source.components);
        }
        auto next = welded.numbers.begin();
        for (std::size_t k = 0; k < polygons_->sizes.size(); ++k)
            for (std::int64_t c = 0; c < polygons_->sizes[k]; ++c)
                attribute.corners.push_back(source.list->sizes[k] > 0 ? *next++ : -1);
        return attribute;
    }

    void assemble_creases() {
        const auto column = [](const Property* property, std::size_t k) {
            return property->values[k];
        };
        const bool have_creases = creases_[0] && creases_[1] && creases_[2];
        for (std::size_t k = 0; have_creases && k < creases_[0]->values.size(); ++k) {
            const auto a = static_cast<std::int32_t>(column(creases_[0], k));
            const auto b = static_cast<std::int32_t>(column(creases_[1], k));
            const double sharpness = sharpness_in_mesh(column(creases_[2], k));
            if (sharpness > 0 && a != b) mesh_.creases.push_back({a, b, sharpness});
        }
        for (std::size_t k = 0; sharp_[0] && sharp_[1] && k < sharp_[0]->values.size(); ++k) {
            const double sharpness = sharpness_in_mesh(column(sharp_[1], k));
            if (sharpness > 0)
                mesh_.sharp_vertices.push_back(
                    {static_cast<std::int32_t>(column(sharp_[0], k)), sharpness});
        }
    }

    std::span<const std::uint8_t> bytes_;
    const std::string& name_;
    ply::Head head_;
    PolygonMesh mesh_;
    std::int64_t vertex_count_ = 0;
    std::array<Property*, 3> places_{};
    std::vector<VertexAttribute> vertex_attributes_;
    const Element* faces_ = nullptr;
    Property* polygons_ = nullptr;
    std::vector<CornerAttribute> corner_attributes_;
    std::array<Property*, ply::kLabels.size()> labels_{};
    std::array<Property*, 3> creases_{};  ///< two vertices, sharpness
    std::array<Property*, 2> sharp_{};    ///< vertex, sharpness
};

}  // namespace

}  // namespace detail

Result<PolygonMesh> parse_ply(std::span<const std::uint8_t> bytes, const std::string& name) {
    return detail::PlyReader(bytes, name).read();
}

}  // namespace relief::io
