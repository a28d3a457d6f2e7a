#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "io/mesh_formats.h"
#include "io/ply.h"

namespace relief::io::detail {

namespace {

/// Rows of numbers, as text or little endian.
class Rows {
  public:
    Rows(std::string& bytes, PlyEncoding encoding)
        : bytes_(bytes), ascii_(encoding == PlyEncoding::Ascii) {}

    void add(SampleType type, double number) {
        if (ascii_) {
            fmt::format_to(std::back_inserter(bytes_), "{}{}", separator_, number);
            separator_ = " ";
        } else {
            add_binary(type, number);
        }
    }
    void add(SampleType type, std::span<const double> numbers) {
        for (const double number : numbers) add(type, number);
    }
    void end() {
        if (ascii_) bytes_ += '\n';
        separator_ = "";
    }

  private:
    void add_binary(SampleType type, double number) {
        switch (type) {
            case SampleType::UInt8:
                return append_little_endian(bytes_, static_cast<std::uint8_t>(number));
            case SampleType::UInt16:
                return append_little_endian(bytes_, static_cast<std::uint16_t>(number));
            case SampleType::Int16:
                return append_little_endian(bytes_, static_cast<std::int16_t>(number));
            case SampleType::UInt32:
                return append_little_endian(bytes_, static_cast<std::uint32_t>(number));
            case SampleType::Int32:
                return append_little_endian(bytes_, static_cast<std::int32_t>(number));
            case SampleType::Float32:
                return append_little_endian(bytes_, static_cast<float>(number));
            case SampleType::Float64:
                return append_little_endian(bytes_, number);
        }
    }

    std::string& bytes_;
    bool ascii_;
    const char* separator_ = "";
};

SampleType type_of_places(const PolygonMesh& mesh) {
    const auto is_float = [](double number) {
        return fits_float(number) && static_cast<double>(static_cast<float>(number)) == number;
    };
    const bool all = std::all_of(mesh.vertices.begin(), mesh.vertices.end(), [&](const Vec3& v) {
        return std::all_of(v.begin(), v.end(), is_float);
    });
    return all ? SampleType::Float32 : SampleType::Float64;
}

class PlyWriter {
  public:
    PlyWriter(const PolygonMesh& mesh, PlyEncoding encoding)
        : mesh_(mesh), encoding_(encoding), places_(type_of_places(mesh)) {
        std::size_t most = 1;  // numbers a corner
        for (const MeshAttribute& attribute : mesh.attributes) {
            if (!attribute.face_varying()) continue;
            most = std::max(most, static_cast<std::size_t>(attribute.components));
        }
        for (std::int64_t k = 0; k < mesh.polygon_count(); ++k)
            if (most * mesh.polygon(k).size() > 255) count_ = SampleType::UInt32;
    }

    EncodedMesh write() {
        write_head();
        Rows rows(file_.bytes, encoding_);
        for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) write_vertex(rows, v);
        for (std::size_t f = 0; f + 1 < mesh_.offsets.size(); ++f) write_face(rows, f);
        for (const CreaseEdge& crease : mesh_.creases) {
            for (const std::int32_t vertex : {crease.a, crease.b}) rows.add(kIndex, vertex);
            rows.add(SampleType::Float64, sharpness_in_file(crease.sharpness));
            rows.end();
        }
        for (const SharpVertex& sharp : mesh_.sharp_vertices) {
            rows.add(kIndex, sharp.vertex);
            rows.add(SampleType::Float64, sharpness_in_file(sharp.sharpness));
            rows.end();
        }
        return std::move(file_);
    }

  private:
    static constexpr SampleType kIndex = SampleType::Int32;

    void write_head() {
        line("ply");
        line("format {} 1.0", encoding_ == PlyEncoding::Ascii ? "ascii" : "binary_little_endian");
        for (const std::string& library : mesh_.libraries)
            line("comment {} {}", ply::kLibrary, library);
        for (const ply::LabelNames& names : ply::kLabels) write_label_names(names);
        line("element vertex {}", mesh_.vertices.size());
        for (const char* name : ply::kPlaces) property(places_, name);
        for (const MeshAttribute& attribute : mesh_.attributes)
            if (!attribute.face_varying()) write_vertex_properties(attribute);
        line("element face {}", mesh_.polygon_count());
        list(kIndex, "vertex_indices");
        for (const MeshAttribute& attribute : mesh_.attributes)
            if (attribute.face_varying()) write_corner_list(attribute);
        for (const auto& [name, labels] : labels_) property(kIndex, name);
        if (!mesh_.creases.empty()) {
            line("element {} {}", ply::kCrease, mesh_.creases.size());
            for (const char* end : ply::kCreaseEnds) property(kIndex, end);
            property(SampleType::Float64, ply::kSharpness);
        }
        if (!mesh_.sharp_vertices.empty()) {
            line("element {} {}", ply::kSharpVertex, mesh_.sharp_vertices.size());
            property(kIndex, ply::kCreaseEnds[0]);
            property(SampleType::Float64, ply::kSharpness);
        }
        line("end_header");
    }

    template <class... Values>
    void line(fmt::format_string<const Values&...> format, const Values&... values) {
        fmt::format_to(std::back_inserter(file_.bytes), format, values...);
        file_.bytes += '\n';
    }
    void property(SampleType type, const char* name) {
        line("property {} {}", ply::name_of(type), name);
    }
    void list(SampleType type, const char* name) {
        line("property list {} {} {}", ply::name_of(count_), ply::name_of(type), name);
    }

    void write_label_names(const ply::LabelNames& names) {
        for (const FaceLabels& labels : mesh_.labels) {
            if (labels.keyword != names.keyword) continue;
            for (const std::string& name : labels.names)
                line("comment {} {}", names.property, name);
            labels_.emplace_back(names.property, &labels);
        }
    }

    void write_vertex_properties(const MeshAttribute& attribute) {
        const auto names = std::find_if(
            ply::kVertexAttributes.begin(), ply::kVertexAttributes.end(),
            [&](const ply::VertexNames& row) { return attribute.name == row.attribute; });
        if (names == ply::kVertexAttributes.end()) return file_.left_out.push_back(attribute.name);
        for (std::size_t k = 0; k < static_cast<std::size_t>(attribute.components); ++k)
            property(attribute.type, names->properties[k]);
        of_vertices_.push_back(&attribute);
    }

    void write_corner_list(const MeshAttribute& attribute) {
        const auto names = std::find_if(
            ply::kCornerAttributes.begin(), ply::kCornerAttributes.end(),
            [&](const ply::CornerNames& row) { return attribute.name == row.attribute; });
        if (names == ply::kCornerAttributes.end()) return file_.left_out.push_back(attribute.name);
        list(attribute.type, names->list);
        of_corners_.push_back(&attribute);
    }

    void write_vertex(Rows& rows, std::size_t v) {
        rows.add(places_, mesh_.vertices[v]);
        for (const MeshAttribute* attribute : of_vertices_)
            rows.add(attribute->type, element(*attribute, static_cast<std::int64_t>(v)));
        rows.end();
    }

    void write_face(Rows& rows, std::size_t f) {
        const auto first = static_cast<std::size_t>(mesh_.offsets[f]);
        const auto size = static_cast<std::size_t>(mesh_.offsets[f + 1]) - first;
        rows.add(count_, static_cast<double>(size));
        for (const std::int32_t vertex : std::span(mesh_.corners).subspan(first, size))
            rows.add(kIndex, vertex);
        for (const MeshAttribute* attribute : of_corners_) {
            const auto elements = std::span(attribute->corners).subspan(first, size);
            const bool has_elements = elements[0] >= 0;
            const auto numbers = size * static_cast<std::size_t>(attribute->components);
            rows.add(count_, has_elements ? static_cast<double>(numbers) : 0);
            if (!has_elements) continue;
            for (const std::int32_t k : elements) rows.add(attribute->type, element(*attribute, k));
        }
        for (const auto& [name, labels] : labels_) rows.add(kIndex, labels->of_face[f]);
        rows.end();
    }

    static std::span<const double> element(const MeshAttribute& attribute, std::int64_t k) {
        return {attribute.element(k), static_cast<std::size_t>(attribute.components)};
    }

    const PolygonMesh& mesh_;
    PlyEncoding encoding_;
    SampleType places_;
    SampleType count_ = SampleType::UInt8;
    EncodedMesh file_;
    std::vector<const MeshAttribute*> of_vertices_;
    std::vector<const MeshAttribute*> of_corners_;
    std::vector<std::pair<const char*, const FaceLabels*>> labels_;
};

}  // namespace

EncodedMesh encode_ply(const PolygonMesh& mesh, PlyEncoding encoding) {
    return PlyWriter(mesh, encoding).write();
}

}  // namespace relief::io::detail
