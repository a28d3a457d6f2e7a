#include "relief/multires/polygon_subdivision.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "relief/mesh/walk.h"
#include "relief/multires/attributes.h"
#include "relief/multires/subdivide.h"

namespace relief::multires {

namespace {

using mesh::Index;
using Points = std::vector<Vec3<double>>;

Sharpness sharpness_of(const PolygonMesh& polygons, const mesh::Topology& mesh, bool corners) {
    Sharpness sharpness;
    std::map<std::pair<Index, Index>, double> creases;
    for (const CreaseEdge& crease : polygons.creases)
        creases[std::minmax(static_cast<Index>(crease.a), static_cast<Index>(crease.b))] =
            crease.sharpness;
    if (!creases.empty()) {
        sharpness.edges.assign(mesh.edge_count, 0);
        mesh::each_edge(mesh, [&](Index h, Index next, Index) {
            const std::pair<Index, Index> ends = std::minmax(mesh.origin[h], mesh.origin[next]);
            if (const auto found = creases.find(ends); found != creases.end())
                sharpness.edges[mesh.edge[h]] = found->second;
        });
    }
    if (!polygons.sharp_vertices.empty() || corners)
        sharpness.vertices.assign(mesh.vertex_count, 0);
    for (const SharpVertex& sharp : polygons.sharp_vertices)
        sharpness.vertices[static_cast<std::size_t>(sharp.vertex)] = sharp.sharpness;
    if (corners) {
        MeshTags tags;
        tag_boundary_corners(mesh, tags);
        for (std::size_t v = 0; v < tags.corner.size(); ++v)
            if (tags.corner[v]) sharpness.vertices[v] = HUGE_VAL;
    }
    return sharpness;
}

/// Attributes of vertices, three components at a time.
void add_attributes(const PolygonMesh& polygons, std::vector<Points>& arrays) {
    for (const MeshAttribute& attribute : polygons.attributes) {
        if (attribute.face_varying() || attribute.name == "normal") continue;
        const auto components = static_cast<std::size_t>(attribute.components);
        for (std::size_t first = 0; first < components; first += 3) {
            Points& array = arrays.emplace_back(polygons.vertices.size());
            for (std::size_t v = 0; v < array.size(); ++v) {
                const double* from = attribute.values.data() + v * components;
                array[v].x = from[first];
                array[v].y = first + 1 < components ? from[first + 1] : 0;
                array[v].z = first + 2 < components ? from[first + 2] : 0;
            }
        }
    }
}

void take_attributes(const PolygonMesh& polygons, const std::vector<Points>& arrays,
                     PolygonMesh& result) {
    std::size_t next = 1;
    for (const MeshAttribute& attribute : polygons.attributes) {
        if (attribute.face_varying() || attribute.name == "normal") continue;
        const auto components = static_cast<std::size_t>(attribute.components);
        MeshAttribute& added = result.attributes.emplace_back();
        added.name = attribute.name;
        added.components = attribute.components;
        added.type = attribute.type;
        added.values.resize(arrays[0].size() * components);
        for (std::size_t k = 0; k < components; ++k) {
            const Points& array = arrays[next + k / 3];
            for (std::size_t v = 0; v < array.size(); ++v) {
                const Vec3<double>& p = array[v];
                const double value = k % 3 == 0 ? p.x : k % 3 == 1 ? p.y : p.z;
                added.values[v * components + k] = stored_value(value, attribute.type, {});
            }
        }
        next += (components + 2) / 3;
    }
}

void take_creases(const SubdividedMesh<double>& fine, PolygonMesh& result) {
    const Sharpness& left = fine.sharpness;
    for (Index h = 0; !left.edges.empty() && h < fine.mesh.half_edge_count(); ++h) {
        const double s = left.edges[fine.mesh.edge[h]];
        if (fine.mesh.is_first(h) && !fine.mesh.on_boundary(h) && s > 0)
            result.creases.push_back({static_cast<std::int32_t>(fine.mesh.origin[h]),
                                      static_cast<std::int32_t>(fine.mesh.target(h)), s});
    }
    for (std::size_t v = 0; v < left.vertices.size(); ++v)
        if (left.vertices[v] > 0)
            result.sharp_vertices.push_back({static_cast<std::int32_t>(v), left.vertices[v]});
}

/// Normals are those of the coarse surface.
bool is_of_corners(const MeshAttribute& attribute) {
    return attribute.face_varying() && attribute.name != "normal";
}

/// What belongs to corners and faces. sqrt(3) has none of it.
Status take_corners(const PolygonMesh& polygons, mesh::Topology mesh, const MeshSpec& spec,
                    int levels, PolygonMesh& result) {
    if (spec.scheme == MeshScheme::Sqrt3) return {};
    std::vector<CornerValues> all;
    for (const MeshAttribute& attribute : polygons.attributes)
        if (is_of_corners(attribute))
            all.push_back({attribute.components, attribute.values, attribute.corners});
    result.labels = polygons.labels;
    if (all.empty() && result.labels.empty()) return {};
    for (int step = 0; step < levels; ++step) {
        const mesh::Split split = spec.split(step);
        for (CornerValues& values : all) values = subdivided(mesh, split, values);
        for (FaceLabels& labels : result.labels)
            labels.of_face = subdivided_labels(mesh, split, labels.of_face);
        RELIEF_TRY(mesh, mesh::refine(mesh, split));
    }
    std::size_t next = 0;
    for (const MeshAttribute& attribute : polygons.attributes) {
        if (!is_of_corners(attribute)) continue;
        CornerValues& values = all[next++];
        for (double& value : values.values) value = stored_value(value, attribute.type, {});
        result.attributes.push_back({attribute.name, attribute.components, attribute.type,
                                     std::move(values.values), std::move(values.of_corner)});
    }
    return {};
}

}  // namespace

Result<PolygonMesh> subdivide(const PolygonMesh& polygons, const MeshSpec& spec,
                              const PolygonSubdivision& options) {
    RELIEF_CHECK(check(polygons));
    const std::vector<Index> corners(polygons.corners.begin(), polygons.corners.end());
    SubdividedMesh<double> mesh;
    RELIEF_TRY(mesh.mesh, mesh::build(polygons.offsets, corners,
                                      static_cast<Index>(polygons.vertices.size())));
    Points& points = mesh.arrays.emplace_back();
    for (const auto& v : polygons.vertices) points.push_back({v[0], v[1], v[2]});
    add_attributes(polygons, mesh.arrays);
    mesh.sharpness = sharpness_of(polygons, mesh.mesh, options.boundary_corners);
    PolygonMesh result;
    RELIEF_TRY(mesh::Topology base, mesh::build(mesh::faces_of(mesh.mesh), mesh.mesh.vertex_count));
    RELIEF_TRY(mesh, subdivide(std::move(mesh), spec, options.steps));
    RELIEF_CHECK(take_corners(polygons, std::move(base), spec, options.steps, result));
    result.libraries = polygons.libraries;
    if (options.limit) {
        const std::span<const Vec3<double>> fine(mesh.arrays[0]);
        RELIEF_TRY(const Points normals,
                   limit_normals<double>(mesh.mesh, fine, mesh.sharpness, spec.scheme));
        RELIEF_TRY(mesh.arrays[0],
                   limit_points<double>(mesh.mesh, fine, mesh.sharpness, spec.scheme));
        MeshAttribute& attribute = result.attributes.emplace_back();
        attribute = {"normal", 3, SampleType::Float32, {}, {}};
        for (const auto& n : normals)
            for (const double x : {n.x, n.y, n.z})
                attribute.values.push_back(static_cast<float>(x));
    }
    for (const auto& p : mesh.arrays[0]) result.vertices.push_back({p.x, p.y, p.z});
    const mesh::FaceList faces = mesh::faces_of(mesh.mesh);
    result.offsets = faces.offsets;
    result.corners.assign(faces.corners.begin(), faces.corners.end());
    take_attributes(polygons, mesh.arrays, result);
    take_creases(mesh, result);
    return result;
}

}  // namespace relief::multires
