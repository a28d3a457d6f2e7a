#include "codec/mesh_extras.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "codec/bytes.h"
#include "codec/mesh_series.h"
#include "relief/mesh/walk.h"

namespace relief::codec {

namespace {

using mesh::Index;
using mesh::kNone;

/// The numbers 0 .. n - 1 in another order, each expected behind the one before.
template <class Coder>
void code_order(Series<Coder>& series, std::vector<Index>& order) {
    std::int64_t expected = 0;
    for (Index& number : order) {
        const std::int64_t value = series.code_near(number, expected, 0);
        number = static_cast<Index>(std::clamp<std::int64_t>(value, 0, kNone));
        expected = value + 1;
    }
}

/// faces: their numbers and which of their corners is the first of the coded face.
struct FacePlace {
    Index face = 0;
    Index turn = 0;
};

template <class Coder>
void code_base_order(Series<Coder>& series, std::vector<Index>& vertices,
                     std::vector<FacePlace>& faces) {
    code_order(series, vertices);
    std::int64_t expected = 0;
    for (FacePlace& place : faces) {
        const std::int64_t face = series.code_near(place.face, expected, 1);
        place.face = static_cast<Index>(std::clamp<std::int64_t>(face, 0, kNone));
        place.turn =
            static_cast<Index>(std::clamp<std::int64_t>(series.code(place.turn, 2), 0, kNone));
        expected = face + 1;
    }
}

}  // namespace

Bytes write_base_order(const CodedBase& coded, const mesh::Topology& base) {
    std::vector<FacePlace> faces;
    bool same = true;
    for (std::size_t f = 0; f < coded.corners.size(); ++f) {
        const Index face = base.face_of(coded.corners[f]);
        faces.push_back({face, coded.corners[f] - base.first_of(face)});
        same = same && face == f && faces.back().turn == 0;
    }
    for (std::size_t v = 0; v < coded.vertices.size(); ++v) same &= coded.vertices[v] == v;
    if (same) return {};
    std::vector<Index> vertices = coded.vertices;
    return encoded([&](auto& series) { code_base_order(series, vertices, faces); });
}

Result<BaseMesh> in_own_order(std::span<const std::uint8_t> bytes, BaseMesh coded) {
    if (bytes.empty()) return coded;
    std::vector<Index> vertices(coded.points.size());
    std::vector<FacePlace> faces(coded.faces.size());
    RELIEF_CHECK(
        decoded(bytes, "base", [&](auto& series) { code_base_order(series, vertices, faces); }));
    std::vector<std::size_t> at(faces.size(), faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (faces[f].face >= faces.size() || at[faces[f].face] != faces.size() ||
            faces[f].turn >= coded.faces[f].size())
            return damaged_chunk("base");
        at[faces[f].face] = f;
    }
    if (!is_permutation(vertices)) return damaged_chunk("base");
    BaseMesh result;
    result.points.resize(coded.points.size());
    for (std::size_t v = 0; v < vertices.size(); ++v) result.points[vertices[v]] = coded.points[v];
    std::vector<Index> corners;
    for (const std::size_t f : at) {
        const auto face = coded.faces[f];
        corners.clear();
        for (std::size_t k = 0; k < face.size(); ++k)
            corners.push_back(vertices[face[(k + face.size() - faces[f].turn) % face.size()]]);
        result.faces.add(corners);
    }
    return result;
}

Bytes write_tags(const multires::MeshTags& tags) {
    const auto none = [](const std::vector<std::uint8_t>& marks) {
        return std::all_of(marks.begin(), marks.end(), [](auto mark) { return mark == 0; });
    };
    if (none(tags.sharp) && none(tags.corner)) return {};
    return encoded([&](auto& series) {
        series.code(none(tags.sharp) ? 0 : 1, 2);
        series.code(none(tags.corner) ? 0 : 1, 2);
        if (!none(tags.sharp))
            for (const std::uint8_t mark : tags.sharp) series.code(mark, 0);
        if (!none(tags.corner))
            for (const std::uint8_t mark : tags.corner) series.code(mark, 1);
    });
}

Result<multires::MeshTags> read_tags(std::span<const std::uint8_t> bytes,
                                     const mesh::Topology& base) {
    multires::MeshTags tags;
    if (bytes.empty()) return tags;
    RELIEF_CHECK(decoded(bytes, "tags", [&](auto& series) {
        tags.sharp.resize(series.code(0, 2) != 0 ? base.edge_count : 0);
        tags.corner.resize(series.code(0, 2) != 0 ? base.vertex_count : 0);
        for (std::uint8_t& mark : tags.sharp) mark = series.code(0, 0) != 0;
        for (std::uint8_t& mark : tags.corner) mark = series.code(0, 1) != 0;
    }));
    return tags;
}

namespace {

/// Integers of an attribute of vertices, in the order of the hierarchy.
class VertexSeries {
  public:
    VertexSeries(const MeshHierarchy& hierarchy, int components)
        : hierarchy_(hierarchy), components_(static_cast<std::size_t>(components)) {}

    template <class Coder>
    void code(Series<Coder>& series, std::vector<std::int64_t>& values) const {
        for (std::size_t v = 0; v < hierarchy_.vertices(0); ++v)
            for (std::size_t c = 0; c < components_; ++c)
                code_one(series, values, v, c, v > 0 ? values[(v - 1) * components_ + c] : 0, 0);
        for (int step = 0; step < hierarchy_.steps(); ++step) code_step(series, values, step);
    }

  private:
    template <class Coder>
    void code_one(Series<Coder>& series, std::vector<std::int64_t>& values, std::size_t v,
                  std::size_t c, std::int64_t expected, std::uint32_t kind) const {
        std::int64_t& value = values[v * components_ + c];
        value = series.code_near(value, expected, kind);
    }

    /// The mean of the ends of the edge, or of the corners of the face.
    template <class Coder>
    void code_step(Series<Coder>& series, std::vector<std::int64_t>& values, int step) const {
        const mesh::Topology& mesh = hierarchy_.topology(step);
        const multires::StepRules& rules = hierarchy_.rules(step);
        const auto code_mean = [&](std::size_t v, std::span<const Index> corners) {
            for (std::size_t c = 0; c < components_; ++c) {
                std::int64_t sum = 0;
                for (const Index w : corners)
                    sum += values[w * components_ + c] / static_cast<std::int64_t>(corners.size());
                code_one(series, values, v, c, sum, 1);
            }
        };
        const bool edges =
            rules.split == mesh::Split::Loop || rules.split == mesh::Split::CatmullClark;
        if (edges)
            mesh::each_edge(mesh, [&](Index h, Index next, Index) {
                const std::array<Index, 2> ends{mesh.origin[h], mesh.origin[next]};
                code_mean(std::size_t{mesh.vertex_count} + mesh.edge[h], ends);
            });
        if (rules.split == mesh::Split::Loop) return;
        for (Index f = 0; f < mesh.face_count; ++f) {
            const bool two = !rules.trisections.empty() && mesh::boundary_side(mesh, f) != kNone;
            for (Index k = 0; k < (two ? 2U : 1U); ++k)
                code_mean(rules.face_points[f] + k, mesh.corners(f));
        }
    }

    const MeshHierarchy& hierarchy_;
    std::size_t components_;
};

/// Which elements the corners have: mostly what the last corner at the vertex had, or the next one.
/// at(corner of the mesh) refers to its element.
template <class Coder, class At>
void code_corners(Series<Coder>& series, const mesh::Topology& finest, const MeshOrder& order,
                  At at) {
    std::vector<std::int64_t> last(finest.vertex_count, -2);
    std::int64_t newest = -1;
    const auto sides = static_cast<Index>(finest.sides);
    for (Index f = 0; f < finest.face_count; ++f)
        for (Index k = 0; k < sides; ++k) {
            const Index first = order.corners[f];
            const Index corner = first / sides * sides + (first % sides + k) % sides;
            std::int64_t element = at(corner);
            std::int64_t& known = last[finest.origin[sides * f + k]];
            const bool same = known != -2 && series.code(element == known ? 0 : 1, 2) == 0;
            element = same ? known : series.code_near(element, newest + 1, 3);
            if (!same) newest = element;
            known = element;
            at(corner) = static_cast<std::int32_t>(
                std::clamp<std::int64_t>(element, -1, std::numeric_limits<std::int32_t>::max()));
        }
}

template <class Coder>
void code_elements(Series<Coder>& series, std::vector<std::int64_t>& values,
                   std::size_t components) {
    for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = series.code_near(values[k], k < components ? 0 : values[k - components], 4);
}

}  // namespace

Bytes write_attributes(const PolygonMesh& mesh, const std::vector<AttributeHeader>& headers,
                       const MeshHierarchy& hierarchy, const MeshOrder& order) {
    if (headers.empty()) return {};
    ByteWriter out;
    for (std::size_t a = 0; a < headers.size(); ++a) {
        const MeshAttribute& attribute = mesh.attributes[a];
        const auto components = static_cast<std::size_t>(attribute.components);
        const Bytes bytes = encoded([&](auto& series) {
            std::vector<std::int64_t> values(attribute.values.size());
            const bool by_vertex = !attribute.face_varying();
            for (std::size_t k = 0; k < values.size(); ++k) {
                const std::size_t from =
                    by_vertex ? order.vertices[k / components] * components + k % components : k;
                values[k] = headers[a].lattice.nearest(attribute.values[from]);
            }
            if (by_vertex)
                return VertexSeries(hierarchy, attribute.components).code(series, values);
            std::vector<std::int32_t> corners = attribute.corners;
            code_corners(series, hierarchy.topology(hierarchy.steps()), order,
                         [&](Index corner) -> std::int32_t& { return corners[corner]; });
            code_elements(series, values, components);
        });
        out.varint(bytes.size());
        out.bytes(bytes);
    }
    return out.take();
}

Result<std::vector<MeshAttribute>> read_attributes(std::span<const std::uint8_t> bytes,
                                                   const std::vector<AttributeHeader>& headers,
                                                   const MeshHierarchy& hierarchy,
                                                   const MeshOrder& order) {
    std::vector<MeshAttribute> attributes;
    const mesh::Topology& finest = hierarchy.topology(hierarchy.steps());
    ByteReader in(bytes);
    for (const AttributeHeader& header : headers) {
        MeshAttribute attribute{header.name, header.components, header.type, {}, {}};
        const auto components = static_cast<std::size_t>(header.components);
        const auto part = in.take(in.varint());
        if (in.failed() || header.elements.value_or(0) > 64 * finest.half_edge_count() + 64)
            return damaged_chunk("attributes");
        const std::size_t elements = header.elements.value_or(finest.vertex_count);
        std::vector<std::int64_t> values(elements * components);
        RELIEF_CHECK(decoded(part, "attributes", [&](auto& series) {
            if (!header.elements)
                return VertexSeries(hierarchy, header.components).code(series, values);
            attribute.corners.resize(finest.half_edge_count());
            code_corners(series, finest, order,
                         [&](Index corner) -> std::int32_t& { return attribute.corners[corner]; });
            code_elements(series, values, components);
        }));
        for (const std::int32_t element : attribute.corners)
            if (element >= static_cast<std::int64_t>(elements)) return damaged_chunk("attributes");
        attribute.values.resize(values.size());
        for (std::size_t k = 0; k < values.size(); ++k) {
            const std::size_t to =
                header.elements ? k : order.vertices[k / components] * components + k % components;
            attribute.values[to] = header.lattice.value(values[k]);
        }
        attributes.push_back(std::move(attribute));
    }
    return attributes;
}

namespace {

template <class Coder>
void code_labels(Series<Coder>& series, const MeshOrder& order, Index sides,
                 std::vector<std::int32_t>& of_face, std::size_t names) {
    std::int64_t last = -1;
    for (const Index corner : order.corners) {
        std::int32_t& label = of_face[corner / sides];
        last = series.code_near(label, last, 0);
        label = static_cast<std::int32_t>(
            std::clamp<std::int64_t>(last, -1, static_cast<std::int64_t>(names) - 1));
    }
}

}  // namespace

Bytes write_labels(const PolygonMesh& mesh, const MeshOrder& order, Index sides) {
    if (mesh.labels.empty()) return {};
    return encoded([&](auto& series) {
        for (FaceLabels labels : mesh.labels)
            code_labels(series, order, sides, labels.of_face, labels.names.size());
    });
}

Status read_labels(std::span<const std::uint8_t> bytes, const MeshOrder& order, Index sides,
                   std::vector<FaceLabels>& labels) {
    if (labels.empty()) return {};
    return decoded(bytes, "labels", [&](auto& series) {
        for (FaceLabels& some : labels) {
            some.of_face.resize(order.corners.size());
            code_labels(series, order, sides, some.of_face, some.names.size());
        }
    });
}

void add_creases(const multires::MeshHierarchy& hierarchy, int depth,
                 std::span<const std::uint8_t> corners, PolygonMesh& mesh) {
    const mesh::Topology& topology = hierarchy.topology(depth);
    const multires::MeshTags& tags = hierarchy.tags(depth);
    for (mesh::Index h = 0; !tags.sharp.empty() && h < topology.half_edge_count(); ++h)
        if (topology.is_first(h) && !topology.on_boundary(h) && tags.sharp[topology.edge[h]])
            mesh.creases.push_back({static_cast<std::int32_t>(topology.origin[h]),
                                    static_cast<std::int32_t>(topology.target(h)), HUGE_VAL});
    for (std::size_t v = 0; v < corners.size(); ++v)
        if (corners[v]) mesh.sharp_vertices.push_back({static_cast<std::int32_t>(v), HUGE_VAL});
}

Bytes write_creases(const PolygonMesh& mesh) {
    if (mesh.creases.empty() && mesh.sharp_vertices.empty()) return {};
    ByteWriter out;
    out.varint(mesh.creases.size());
    for (const CreaseEdge& crease : mesh.creases) {
        out.varint(static_cast<std::uint64_t>(crease.a));
        out.varint(static_cast<std::uint64_t>(crease.b));
        out.f64(crease.sharpness);
    }
    out.varint(mesh.sharp_vertices.size());
    for (const SharpVertex& sharp : mesh.sharp_vertices) {
        out.varint(static_cast<std::uint64_t>(sharp.vertex));
        out.f64(sharp.sharpness);
    }
    return out.take();
}

Status read_creases(std::span<const std::uint8_t> bytes, PolygonMesh& mesh) {
    if (bytes.empty()) return {};
    ByteReader in(bytes);
    const auto vertex = [&] {
        return static_cast<std::int32_t>(std::min<std::uint64_t>(in.varint(), INT32_MAX));
    };
    // An entry has 9 bytes at least.
    const std::uint64_t creases = std::min<std::uint64_t>(in.varint(), bytes.size());
    for (std::uint64_t k = 0; k < creases && !in.failed(); ++k) {
        CreaseEdge crease;
        crease.a = vertex();
        crease.b = vertex();
        crease.sharpness = in.f64();
        mesh.creases.push_back(crease);
    }
    const std::uint64_t sharp = std::min<std::uint64_t>(in.varint(), bytes.size());
    for (std::uint64_t k = 0; k < sharp && !in.failed(); ++k) {
        SharpVertex vertex_tag;
        vertex_tag.vertex = vertex();
        vertex_tag.sharpness = in.f64();
        mesh.sharp_vertices.push_back(vertex_tag);
    }
    if (!in.failed() && in.rest().empty()) return {};
    return damaged_chunk("creases");
}

namespace {

template <class Coder, class Visit>
void code_exact(Series<Coder>& series, std::size_t count, const ValueLattice& lattice,
                Visit visit) {
    for (std::size_t v = 0; v < count; ++v)
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            const auto [exact, expected] = visit(v, axis);
            *exact = lattice.value(
                series.code_near(lattice.nearest(*exact), lattice.nearest(expected), axis));
        }
}

double& axis_of(Vec3<double>& p, std::uint32_t axis) {
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

}  // namespace

Bytes write_exact(std::span<const Vec3<double>> decoded_points, std::span<const Vec3<double>> exact,
                  const ValueLattice& lattice) {
    return encoded([&](auto& series) {
        Vec3<double> value;
        Vec3<double> expected;
        code_exact(series, exact.size(), lattice, [&](std::size_t v, std::uint32_t axis) {
            if (axis == 0) {
                value = exact[v];
                expected = decoded_points[v];
            }
            return std::pair(&axis_of(value, axis), axis_of(expected, axis));
        });
    });
}

Status read_exact(std::span<const std::uint8_t> bytes, const ValueLattice& lattice,
                  std::span<Vec3<double>> points) {
    return decoded(bytes, "exact", [&](auto& series) {
        code_exact(series, points.size(), lattice, [&](std::size_t v, std::uint32_t axis) {
            double& value = axis_of(points[v], axis);
            return std::pair(&value, value);
        });
    });
}

}  // namespace relief::codec
