#include "relief/core/polygon_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace relief {

namespace {

Error broken(std::string message, std::string where) {
    return {ErrorCode::BadInput, std::move(message), std::move(where)};
}

std::string element_name(const char* kind, std::size_t number) {
    return kind + (" " + std::to_string(number));
}

/// Whether each number is one of `count` elements, or -1 where that may be.
bool all_below(std::span<const std::int32_t> numbers, std::size_t count, std::int32_t lowest) {
    return std::all_of(numbers.begin(), numbers.end(), [&](std::int32_t number) {
        return number >= lowest && (number < 0 || static_cast<std::size_t>(number) < count);
    });
}

Status check_polygons(const PolygonMesh& mesh) {
    constexpr std::size_t most = std::numeric_limits<std::int32_t>::max();
    if (mesh.vertices.size() > most || mesh.offsets.size() > most || mesh.corners.size() > most)
        return broken("too_many_elements: at most 2^31 - 1 vertices, polygons and corners", "");
    if (mesh.offsets.empty() || mesh.offsets.front() != 0 ||
        mesh.offsets.back() != static_cast<std::int64_t>(mesh.corners.size()))
        return broken("wrong_size: offsets begin with 0 and end with the number of corners", "");
    for (std::size_t k = 0; k + 1 < mesh.offsets.size(); ++k)
        if (mesh.offsets[k + 1] - mesh.offsets[k] < 3)
            return broken("wrong_size: a polygon has at least 3 corners",
                          element_name("polygon", k));
    for (std::int64_t k = 0; k < mesh.polygon_count(); ++k)
        if (!all_below(mesh.polygon(k), mesh.vertices.size(), 0))
            return broken("index_out_of_range: a corner names a vertex that does not exist",
                          element_name("polygon", static_cast<std::size_t>(k)));
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        for (const double coordinate : mesh.vertices[v])
            if (!std::isfinite(coordinate))
                return broken("non_finite_vertex: a coordinate is not a finite number",
                              element_name("vertex", v));
    return {};
}

bool has_known_components(const MeshAttribute& attribute) {
    if (attribute.name == "uv") return attribute.components == 2 || attribute.components == 3;
    if (attribute.name == "colour") return attribute.components == 3 || attribute.components == 4;
    if (attribute.name == "normal") return attribute.components == 3;
    return attribute.components > 0;
}

Status check_values(const MeshAttribute& attribute, const std::string& where) {
    for (const double value : attribute.values) {
        if (!std::isfinite(value))
            return broken("non_finite_value: a value is not a finite number", where);
        if (stored_value(value, attribute.type, std::nullopt) != value)
            return broken("inexact_value: a value is not exact in the type " +
                              std::string(sample_type_name(attribute.type)),
                          where);
    }
    return {};
}

Status check_attribute(const MeshAttribute& attribute, const PolygonMesh& mesh) {
    const std::string where = "attribute " + attribute.name;
    if (!has_known_components(attribute))
        return broken("wrong_size: so many components are not known", where);
    const auto components = static_cast<std::size_t>(attribute.components);
    if (attribute.values.size() % components != 0)
        return broken("wrong_size: values are not a multiple of the components", where);
    const std::size_t elements = attribute.values.size() / components;
    RELIEF_CHECK(check_values(attribute, where));
    if (!attribute.face_varying()) {
        if (elements == mesh.vertices.size()) return {};
        return broken("wrong_size: an attribute of the vertices has an element for each", where);
    }
    if (attribute.corners.size() != mesh.corners.size())
        return broken("wrong_size: a face-varying attribute has a number for each corner", where);
    if (!all_below(attribute.corners, elements, -1))
        return broken("index_out_of_range: a corner names an element that does not exist", where);
    for (std::int64_t k = 0; k < mesh.polygon_count(); ++k) {
        const auto* first = attribute.corners.data() + mesh.offsets[static_cast<std::size_t>(k)];
        const auto without =
            std::count(first, first + static_cast<std::ptrdiff_t>(mesh.polygon(k).size()), -1);
        if (without != 0 && static_cast<std::size_t>(without) != mesh.polygon(k).size())
            return broken(
                "index_out_of_range: polygon " + std::to_string(k) + " has only some elements",
                where);
    }
    return {};
}

Status check_labels(const FaceLabels& labels, const PolygonMesh& mesh) {
    const std::string where = "labels " + labels.keyword;
    constexpr std::array<std::string_view, 4> known = {"o", "g", "usemtl", "s"};
    if (std::find(known.begin(), known.end(), labels.keyword) == known.end())
        return broken("unknown_keyword: labels are o, g, usemtl or s", where);
    if (!std::all_of(labels.names.begin(), labels.names.end(), is_label_name))
        return broken("bad_name: a name can not stand on a line", where);
    if (labels.of_face.size() + 1 != mesh.offsets.size())
        return broken("wrong_size: there is a number for each polygon", where);
    if (!all_below(labels.of_face, labels.names.size(), -1))
        return broken("index_out_of_range: a polygon has a name that does not exist", where);
    return {};
}

Status check_sharpness(double sharpness, const std::string& where) {
    if ((sharpness > 0 && sharpness < kSharpest) || sharpness == HUGE_VAL) return {};
    return broken("bad_sharpness: it lies between 0 and 10 or is infinite", where);
}

Status check_creases(const PolygonMesh& mesh) {
    for (std::size_t k = 0; k < mesh.creases.size(); ++k) {
        const CreaseEdge& crease = mesh.creases[k];
        const std::string where = element_name("crease", k);
        if (crease.a == crease.b ||
            !all_below(std::array{crease.a, crease.b}, mesh.vertices.size(), 0))
            return broken("index_out_of_range: a crease joins two different vertices", where);
        RELIEF_CHECK(check_sharpness(crease.sharpness, where));
    }
    for (std::size_t k = 0; k < mesh.sharp_vertices.size(); ++k) {
        const SharpVertex& sharp = mesh.sharp_vertices[k];
        const std::string where = element_name("sharp vertex", k);
        if (!all_below(std::array{sharp.vertex}, mesh.vertices.size(), 0))
            return broken("index_out_of_range: there is no such vertex", where);
        RELIEF_CHECK(check_sharpness(sharp.sharpness, where));
    }
    return {};
}

/// A member that no two elements of a list may share.
template <class Element>
Status check_distinct(const std::vector<Element>& list, std::string Element::*key) {
    for (std::size_t k = 1; k < list.size(); ++k)
        for (std::size_t j = 0; j < k; ++j)
            if (list[j].*key == list[k].*key)
                return broken("named_twice: '" + list[k].*key + "' stands for two things", "");
    return {};
}

}  // namespace

bool is_label_name(std::string_view name) {
    constexpr std::string_view blanks = " \t\r\v\f";
    const auto is_blank = [&](char c) { return blanks.find(c) != std::string_view::npos; };
    if (name.empty() || is_blank(name.front()) || is_blank(name.back()) || name.back() == '\\')
        return false;
    for (std::size_t k = 0; k < name.size(); ++k)
        if (name[k] == '\n' || (name[k] == '#' && (k == 0 || is_blank(name[k - 1])))) return false;
    return true;
}

Status check(const PolygonMesh& mesh) {
    RELIEF_CHECK(check_polygons(mesh));
    RELIEF_CHECK(check_distinct(mesh.attributes, &MeshAttribute::name));
    for (const MeshAttribute& attribute : mesh.attributes)
        RELIEF_CHECK(check_attribute(attribute, mesh));
    RELIEF_CHECK(check_distinct(mesh.labels, &FaceLabels::keyword));
    for (const FaceLabels& labels : mesh.labels) RELIEF_CHECK(check_labels(labels, mesh));
    if (!std::all_of(mesh.libraries.begin(), mesh.libraries.end(), is_label_name))
        return broken("bad_name: a name can not stand on a line", "libraries");
    return check_creases(mesh);
}

double diagonal_of(const PolygonMesh& mesh) {
    if (mesh.vertices.empty()) return 0;
    std::array<double, 3> sides{};
    for (std::size_t k = 0; k < 3; ++k) {
        const auto [least, most] =
            std::minmax_element(mesh.vertices.begin(), mesh.vertices.end(),
                                [k](const auto& a, const auto& b) { return a[k] < b[k]; });
        sides[k] = (*most)[k] - (*least)[k];
    }
    return std::hypot(sides[0], sides[1], sides[2]);
}

}  // namespace relief
