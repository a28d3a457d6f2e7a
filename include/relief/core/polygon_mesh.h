#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "relief/core/raster.h"
#include "relief/core/result.h"

/// A polygon mesh in memory: what readers deliver, what transforms and the codec keep, what writers
/// take. No file format here.
namespace relief {

/// Numbers at the vertices or at the corners of the polygons. Three names are known: "uv" (2 or 3
/// components), "colour" (3 or 4; floats from 0 to 1, integers from 0 to the largest of their type)
/// and "normal" (3).
struct MeshAttribute {
    std::string name;
    int components = 0;
    SampleType type = SampleType::Float64;  ///< how a file stores it; the values are exact in it
    std::vector<double> values = {};        ///< `components` an element; finite
    /// Empty: element v belongs to vertex v. Otherwise face-varying: an element number for each
    /// corner of the mesh, or -1 at all corners of a polygon that has no elements.
    std::vector<std::int32_t> corners = {};

    [[nodiscard]] std::int64_t element_count() const {
        return static_cast<std::int64_t>(values.size()) / components;
    }
    [[nodiscard]] const double* element(std::int64_t k) const {
        return values.data() + k * components;
    }
    [[nodiscard]] bool face_varying() const { return !corners.empty(); }

    friend bool operator==(const MeshAttribute&, const MeshAttribute&) = default;
};

/// Whether a line of a text file can end with this name: it is not empty, has no line break, no
/// blanks at its ends and no backslash at its last one, and no word of it begins with #.
[[nodiscard]] bool is_label_name(std::string_view name);

/// What the polygons are called in one respect: their groups ("g"), objects ("o"), materials
/// ("usemtl") or smoothing groups ("s").
struct FaceLabels {
    std::string keyword;
    std::vector<std::string> names = {};     ///< each passes is_label_name
    std::vector<std::int32_t> of_face = {};  ///< a number of a name for each polygon; -1: none

    friend bool operator==(const FaceLabels&, const FaceLabels&) = default;
};

/// The sharpness of creases and corners of subdivision surfaces lies between 0 and kSharpest, or is
/// HUGE_VAL: sharp for ever.
inline constexpr double kSharpest = 10;

struct CreaseEdge {
    std::int32_t a = 0;  ///< numbers of different vertices
    std::int32_t b = 0;
    double sharpness = 0;

    friend bool operator==(const CreaseEdge&, const CreaseEdge&) = default;
};

struct SharpVertex {
    std::int32_t vertex = 0;
    double sharpness = 0;

    friend bool operator==(const SharpVertex&, const SharpVertex&) = default;
};

/// Polygon k has the corners corners[offsets[k]] .. corners[offsets[k + 1] - 1], at least three,
/// which are numbers of vertices. At most 2^31 - 1 vertices, polygons and corners.
struct PolygonMesh {
    std::vector<std::array<double, 3>> vertices = {};  ///< finite
    std::vector<std::int64_t> offsets = {0};
    std::vector<std::int32_t> corners = {};
    std::vector<MeshAttribute> attributes = {};  ///< no name twice
    std::vector<FaceLabels> labels = {};         ///< no keyword twice
    std::vector<std::string> libraries = {};     ///< files of materials; each passes is_label_name
    std::vector<CreaseEdge> creases = {};
    std::vector<SharpVertex> sharp_vertices = {};

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
    /// Null: there is none of this name.
    [[nodiscard]] const MeshAttribute* attribute(std::string_view name) const {
        for (const MeshAttribute& candidate : attributes)
            if (candidate.name == name) return &candidate;
        return nullptr;
    }

    friend bool operator==(const PolygonMesh&, const PolygonMesh&) = default;
};

/// Verifies everything that is said above. Errors: BadInput, a message that begins with the name of
/// the rule (index_out_of_range, non_finite_vertex, ..) and the element in `where`. Complexity:
/// O(size).
[[nodiscard]] Status check(const PolygonMesh& mesh);

/// The length of the diagonal of the box around the vertices; 0 without any.
[[nodiscard]] double diagonal_of(const PolygonMesh& mesh);

}  // namespace relief
