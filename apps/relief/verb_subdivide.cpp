#include <fmt/format.h>

#include <cmath>
#include <map>

#include "command.h"
#include "mesh_verbs.h"
#include "relief/io/mesh.h"
#include "relief/mesh/repair.h"
#include "relief/mesh/walk.h"
#include "relief/multires/attributes.h"
#include "relief/multires/subdivide.h"

namespace relief::cli {

namespace {

using mesh::Index;
using Points = std::vector<Vec3<double>>;

struct Subdivide {
    std::string in;
    std::string out;
    std::string scheme;
    int levels = 1;
    bool limit = false;
    bool corners = false;
    bool repair = false;
};

multires::Sharpness sharpness_of(const PolygonMesh& polygons, const mesh::Topology& mesh,
                                 bool corners) {
    multires::Sharpness sharpness;
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
        multires::MeshTags tags;
        multires::tag_boundary_corners(mesh, tags);
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

void take_creases(const multires::SubdividedMesh<double>& fine, PolygonMesh& result) {
    const multires::Sharpness& left = fine.sharpness;
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
Status take_corners(const PolygonMesh& polygons, mesh::Topology mesh,
                    const multires::MeshSpec& spec, int levels, PolygonMesh& result) {
    if (spec.scheme == multires::MeshScheme::Sqrt3) return {};
    std::vector<multires::CornerValues> all;
    for (const MeshAttribute& attribute : polygons.attributes)
        if (is_of_corners(attribute))
            all.push_back({attribute.components, attribute.values, attribute.corners});
    result.labels = polygons.labels;
    if (all.empty() && result.labels.empty()) return {};
    for (int step = 0; step < levels; ++step) {
        const mesh::Split split = spec.split(step);
        for (multires::CornerValues& values : all)
            values = multires::subdivided(mesh, split, values);
        for (FaceLabels& labels : result.labels)
            labels.of_face = multires::subdivided_labels(mesh, split, labels.of_face);
        RELIEF_TRY(mesh, mesh::refine(mesh, split));
    }
    std::size_t next = 0;
    for (const MeshAttribute& attribute : polygons.attributes) {
        if (!is_of_corners(attribute)) continue;
        multires::CornerValues& values = all[next++];
        for (double& value : values.values) value = stored_value(value, attribute.type, {});
        result.attributes.push_back({attribute.name, attribute.components, attribute.type,
                                     std::move(values.values), std::move(values.of_corner)});
    }
    return {};
}

Result<PolygonMesh> subdivided(const PolygonMesh& polygons, const Subdivide& options) {
    multires::MeshSpec spec;
    RELIEF_TRY(spec.scheme, mesh_scheme(options.scheme));
    const std::vector<Index> corners(polygons.corners.begin(), polygons.corners.end());
    multires::SubdividedMesh<double> mesh;
    RELIEF_TRY(mesh.mesh, mesh::build(polygons.offsets, corners,
                                      static_cast<Index>(polygons.vertices.size())));
    Points& points = mesh.arrays.emplace_back();
    for (const auto& v : polygons.vertices) points.push_back({v[0], v[1], v[2]});
    add_attributes(polygons, mesh.arrays);
    mesh.sharpness = sharpness_of(polygons, mesh.mesh, options.corners);
    PolygonMesh result;
    RELIEF_TRY(mesh::Topology base, mesh::build(mesh::faces_of(mesh.mesh), mesh.mesh.vertex_count));
    RELIEF_TRY(mesh, multires::subdivide(std::move(mesh), spec, options.levels));
    RELIEF_CHECK(take_corners(polygons, std::move(base), spec, options.levels, result));
    result.libraries = polygons.libraries;
    if (options.limit) {
        const std::span<const Vec3<double>> fine(mesh.arrays[0]);
        RELIEF_TRY(const Points normals,
                   multires::limit_normals<double>(mesh.mesh, fine, mesh.sharpness, spec.scheme));
        RELIEF_TRY(mesh.arrays[0],
                   multires::limit_points<double>(mesh.mesh, fine, mesh.sharpness, spec.scheme));
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

Result<Outcome> run(const Subdivide& options) {
    const Stopwatch watch;
    RELIEF_TRY(PolygonMesh polygons, read_polygons(options.in));
    if (options.repair) polygons = mesh::repair(polygons).mesh;
    const auto fine = subdivided(polygons, options);
    if (!fine.ok()) return located(fine.error(), options.in);
    RELIEF_TRY(const auto missing, io::write_mesh(options.out, *fine));
    Outcome outcome;
    outcome.json = Json{{"vertices", fine->vertices.size()},
                        {"faces", fine->polygon_count()},
                        {"left_out", missing},
                        {"seconds", watch.seconds()}};
    outcome.text = fmt::format("{}: {} vertices, {} faces\n", options.out,
                               grouped(static_cast<std::int64_t>(fine->vertices.size())),
                               grouped(fine->polygon_count())) +
                   left_out(missing);
    return outcome;
}

}  // namespace

void add_subdivide(Program& program) {
    auto options = std::make_shared<Subdivide>();
    CLI::App* verb =
        add_verb(program, "subdivide",
                 "Subdivide a mesh: smooth surfaces with boundaries, creases and corners.",
                 "  relief subdivide cube.obj smooth.ply --scheme catmull-clark --levels 4\n"
                 "  relief subdivide model.stl limit.glb --scheme loop --levels 2 --limit",
                 [options] { return run(*options); });
    verb->add_option("IN", options->in, "a mesh (.obj, .off, .ply, .stl) or a .relief file of one")
        ->required();
    verb->add_option("OUT", options->out, "the mesh: .obj, .off, .ply, .stl, .glb")->required();
    verb->add_option("--scheme", options->scheme,
                     "sqrt3 and loop for triangles, catmull-clark for all polygons")
        ->required()
        ->check(CLI::IsMember({"sqrt3", "loop", "catmull-clark"}));
    verb->add_option("--levels", options->levels, "how often (default 1)")
        ->check(CLI::Range(0, 30));
    verb->add_flag("--limit", options->limit,
                   "move the vertices to where they go in the end, with the normals there");
    verb->add_flag("--boundary-corners", options->corners,
                   "boundary vertices of one face stay where they are");
    verb->add_flag("--repair", options->repair,
                   "first mend what is no oriented manifold: see 'relief info'");
}

}  // namespace relief::cli
