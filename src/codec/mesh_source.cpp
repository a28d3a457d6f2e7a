#include "codec/mesh_source.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "relief/mesh/walk.h"

namespace relief::codec {

namespace {

using mesh::Index;
using mesh::Topology;
using multires::MeshOrigin;
using multires::MeshScheme;
using multires::MeshTags;

MeshPoints points_of(const PolygonMesh& mesh) {
    MeshPoints points;
    points.reserve(mesh.vertices.size());
    for (const auto& v : mesh.vertices) points.push_back({v[0], v[1], v[2]});
    return points;
}

/// What is sharp for ever takes part in the transform.
MeshTags tags_of(const PolygonMesh& mesh, const Topology& topology) {
    MeshTags tags;
    std::map<std::pair<Index, Index>, bool> sharp;
    for (const CreaseEdge& crease : mesh.creases)
        if (std::isinf(crease.sharpness))
            sharp[std::minmax(static_cast<Index>(crease.a), static_cast<Index>(crease.b))] = true;
    if (!sharp.empty()) {
        tags.sharp.assign(topology.edge_count, 0);
        mesh::each_edge(topology, [&](Index h, Index next, Index) {
            const std::pair<Index, Index> ends =
                std::minmax(topology.origin[h], topology.origin[next]);
            tags.sharp[topology.edge[h]] = !topology.on_boundary(h) && sharp.count(ends) > 0;
        });
    }
    for (const SharpVertex& vertex : mesh.sharp_vertices) {
        if (!std::isinf(vertex.sharpness)) continue;
        tags.corner.resize(topology.vertex_count, 0);
        tags.corner[static_cast<std::size_t>(vertex.vertex)] = 1;
    }
    return tags;
}

double squared_details(const MeshSource& source) {
    const MeshCoefficients coefficients = coefficients_of(source.synthesis, source.points);
    double sum = 0;
    for (std::size_t k = source.base.vertex_count; k < coefficients.points.size(); ++k)
        sum += dot(coefficients.points[k], coefficients.points[k]);
    return sum;
}

Topology copy_of(const Topology& mesh) {
    return *mesh::build(mesh::faces_of(mesh), mesh.vertex_count);
}

/// Boundary vertices with one face move or stay: what leaves smaller details.
Status choose_corners(MeshSource& source) {
    MeshTags corners;
    multires::tag_boundary_corners(source.base, corners);
    if (std::find(corners.corner.begin(), corners.corner.end(), 1) == corners.corner.end())
        return {};
    const double without = squared_details(source);
    source.header.boundary_corners = true;
    MeshSynthesis before = std::move(source.synthesis);
    RELIEF_TRY(source.synthesis, MeshSynthesis::create(copy_of(source.base), source.tags,
                                                       source.header, source.header.levels));
    if (squared_details(source) < without) return {};
    source.header.boundary_corners = false;
    source.synthesis = std::move(before);
    return {};
}

/// Where the vertices and faces of the hierarchy are in the mesh.
MeshOrder order_of(const Topology& mesh, const Topology& finest, const MeshOrigin& origin) {
    MeshOrder order;
    order.vertices.resize(finest.vertex_count);
    for (Index h = 0; h < finest.half_edge_count(); ++h)
        order.vertices[finest.origin[h]] = mesh.origin[origin.half_edge(h)];
    const auto sides = static_cast<Index>(finest.sides);
    for (Index f = 0; f < finest.face_count; ++f)
        order.corners.push_back(origin.half_edge(sides * f));
    return order;
}

std::vector<AttributeHeader> attribute_headers(const PolygonMesh& mesh) {
    std::vector<AttributeHeader> headers;
    for (const MeshAttribute& attribute : mesh.attributes) {
        AttributeHeader& header = headers.emplace_back();
        header.name = attribute.name;
        header.components = attribute.components;
        header.type = attribute.type;
        if (attribute.face_varying())
            header.elements = static_cast<std::uint64_t>(attribute.element_count());
        header.lattice = ValueLattice::exact(attribute.values);
    }
    return headers;
}

}  // namespace

PolygonMesh reordered(const PolygonMesh& mesh, const MeshOrder& order, Index sides) {
    PolygonMesh result;
    result.libraries = mesh.libraries;
    std::vector<std::int32_t> number(order.vertices.size());
    for (std::size_t v = 0; v < order.vertices.size(); ++v) {
        number[order.vertices[v]] = static_cast<std::int32_t>(v);
        result.vertices.push_back(mesh.vertices[order.vertices[v]]);
    }
    std::vector<std::size_t> corners;  // as they were
    for (const Index first : order.corners) {
        for (Index k = 0; k < sides; ++k)
            corners.push_back(first / sides * sides + (first % sides + k) % sides);
        result.offsets.push_back(static_cast<std::int64_t>(corners.size()));
    }
    for (const std::size_t corner : corners)
        result.corners.push_back(number[static_cast<std::size_t>(mesh.corners[corner])]);
    for (const MeshAttribute& attribute : mesh.attributes) {
        MeshAttribute& added = result.attributes.emplace_back(attribute);
        const auto components = static_cast<std::size_t>(attribute.components);
        for (std::size_t k = 0; !attribute.face_varying() && k < added.values.size(); ++k)
            added.values[k] =
                attribute.values[order.vertices[k / components] * components + k % components];
        for (std::size_t k = 0; k < added.corners.size(); ++k)
            added.corners[k] = attribute.corners[corners[k]];
    }
    for (const FaceLabels& labels : mesh.labels) {
        FaceLabels& added = result.labels.emplace_back(labels);
        for (std::size_t f = 0; f < added.of_face.size(); ++f)
            added.of_face[f] = labels.of_face[order.corners[f] / sides];
    }
    for (const CreaseEdge& crease : mesh.creases)
        result.creases.push_back({number[static_cast<std::size_t>(crease.a)],
                                  number[static_cast<std::size_t>(crease.b)], crease.sharpness});
    for (const SharpVertex& sharp : mesh.sharp_vertices)
        result.sharp_vertices.push_back(
            {number[static_cast<std::size_t>(sharp.vertex)], sharp.sharpness});
    return result;
}

std::vector<Index> corners_of(const PolygonMesh& mesh) {
    return {mesh.corners.begin(), mesh.corners.end()};
}

MeshCoefficients coefficients_of(const MeshSynthesis& synthesis, const MeshPoints& points) {
    MeshCoefficients coefficients{points, {}};
    synthesis.maps().analyse(coefficients.points.data(), coefficients.residuals);
    return coefficients;
}

Result<MeshSource> prepare_mesh(const PolygonMesh& mesh, MeshScheme scheme,
                                const MeshEncodeOptions& options) {
    RELIEF_TRY(const Topology topology, mesh::build(mesh.offsets, corners_of(mesh),
                                                    static_cast<Index>(mesh.vertices.size())));
    const MeshPoints points = points_of(mesh);
    const MeshTags tags = tags_of(mesh, topology);
    RELIEF_TRY(MeshOrigin origin, multires::origin_of(topology, points, tags, scheme,
                                                      options.levels < 0 ? 30 : options.levels));
    // A mesh that has the numbers of its hierarchy keeps the order of the base. Else the base is
    // numbered as it is coded.
    if (!options.keep_order || !origin.in_order()) {
        const CodedBase coded =
            encode_base(origin.base, std::vector<GridPoint>(origin.base.vertex_count));
        RELIEF_TRY(origin, multires::renumbered(origin, coded.vertices, coded.corners));
    }
    MeshSource source;
    source.sides = static_cast<Index>(topology.sides);
    source.lost_creases = static_cast<std::int64_t>(origin.lost_creases.size());
    MeshHeader& header = source.header;
    header.spec = origin.spec;
    header.spec.alpha = options.alpha;
    header.lift = options.lift;
    header.levels = origin.steps;
    header.sides = origin.base.sides;
    header.base_vertices = origin.base.vertex_count;
    header.base_faces = origin.base.face_count;
    header.goal = options.goal;
    header.distance = options.distance;
    header.attributes = attribute_headers(mesh);
    for (const FaceLabels& labels : mesh.labels)
        header.labels.push_back({labels.keyword, labels.names, {}});
    header.libraries = mesh.libraries;
    source.base = copy_of(origin.base);
    source.tags = origin.tags;
    RELIEF_TRY(source.synthesis,
               MeshSynthesis::create(std::move(origin.base), origin.tags, header, header.levels));
    source.order = order_of(topology, source.hierarchy().topology(header.levels), origin);
    for (const Index v : source.order.vertices) source.points.push_back(points[v]);
    RELIEF_CHECK(choose_corners(source));
    return source;
}

}  // namespace relief::codec
