#include "relief/codec/polygons.h"

#include <algorithm>
#include <string>

namespace relief::codec {

namespace ps = multires::ps;
using mesh::Index;

namespace {

/// A mesh in the plane of its texture coordinates.
struct Unwrapped {
    PolygonMesh mesh;
    std::vector<std::int32_t> origin;  ///< of each vertex that in space
};

/// Vertices with several texture coordinates, at seams, become several vertices.
Result<Unwrapped> unwrap(const PolygonMesh& mesh) {
    const MeshAttribute* uv = mesh.attribute("uv");
    if (uv == nullptr)
        return Error{ErrorCode::BadInput,
                     "has no texture coordinates, which are to be the parameters of the surface",
                     ""};
    using VertexElement = std::array<std::int32_t, 2>;
    std::vector<VertexElement> corners;
    for (std::size_t k = 0; k < mesh.corners.size(); ++k) {
        const std::int32_t element = uv->face_varying() ? uv->corners[k] : mesh.corners[k];
        if (element < 0)
            return Error{ErrorCode::BadInput, "has faces without texture coordinates", ""};
        corners.push_back({mesh.corners[k], element});
    }
    std::vector<VertexElement> vertices = corners;
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    Unwrapped flat;
    for (const auto& [vertex, element] : vertices) {
        flat.mesh.vertices.push_back({uv->element(element)[0], uv->element(element)[1], 0});
        flat.origin.push_back(vertex);
    }
    flat.mesh.offsets = mesh.offsets;
    for (const VertexElement& corner : corners) {
        const auto found = std::lower_bound(vertices.begin(), vertices.end(), corner);
        flat.mesh.corners.push_back(static_cast<std::int32_t>(found - vertices.begin()));
    }
    return flat;
}

}  // namespace

bool is_over_plane(const PolygonMesh& mesh) {
    std::int64_t upwards = 0;
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
        const auto polygon = mesh.polygon(f);
        if (polygon.size() != 4) continue;
        QuadCorners corners;
        for (std::size_t k = 0; k < 4; ++k) {
            const auto& v = mesh.vertices[static_cast<std::size_t>(polygon[k])];
            corners[k] = {v[0], v[1]};
        }
        upwards += doubled_area(corners) > 0;
    }
    return upwards > 0 && 4 * upwards >= 3 * mesh.polygon_count();
}

Result<QuadMesh> quads_of(const PolygonMesh& polygons) {
    QuadMesh mesh{polygons.vertices, {}};
    for (std::int64_t k = 0; k < polygons.polygon_count(); ++k) {
        const auto polygon = polygons.polygon(k);
        if (polygon.size() != 4)
            return Error{ErrorCode::BadInput,
                         "not_a_quad: it has " + std::to_string(polygon.size()) +
                             " corners; split every n-gon into n quads at its centre first",
                         "polygon " + std::to_string(k)};
        auto& quad = mesh.quads.emplace_back();
        std::copy(polygon.begin(), polygon.end(), quad.begin());
    }
    return mesh;
}

PolygonMesh polygons_of(const QuadMesh& mesh) {
    PolygonMesh polygons;
    polygons.vertices = mesh.vertices;
    for (const auto& quad : mesh.quads) {
        std::array<std::int32_t, 4> corners{};
        std::copy(quad.begin(), quad.end(), corners.begin());
        polygons.add_polygon(corners);
    }
    return polygons;
}

Result<mesh::Triangulation> triangulation_of(const PolygonMesh& polygons) {
    std::vector<Vec2> vertices;
    for (const auto& v : polygons.vertices) vertices.push_back({v[0], v[1]});
    std::vector<std::array<mesh::Index, 3>> triangles;
    for (std::int64_t k = 0; k < polygons.polygon_count(); ++k) {
        const auto polygon = polygons.polygon(k);
        if (polygon.size() != 3)
            return Error{ErrorCode::BadInput,
                         "not_a_triangle: it has " + std::to_string(polygon.size()) +
                             " corners; cut it into triangles first",
                         "polygon " + std::to_string(k)};
        auto& triangle = triangles.emplace_back();
        std::transform(polygon.begin(), polygon.end(), triangle.begin(),
                       [](std::int32_t v) { return static_cast<mesh::Index>(v); });
    }
    return mesh::build(vertices, triangles, {.check_overlap = true});
}

Result<PsModel> model_of(const PolygonMesh& mesh) {
    RELIEF_TRY(mesh::Triangulation base, triangulation_of(mesh));
    PsValues values;
    values.components.resize(1);
    for (const auto& v : mesh.vertices) values.components[0].push_back(v[2]);
    return PsModel{std::move(base), std::move(values)};
}

Result<PsModel> model_over_uv(const PolygonMesh& mesh) {
    RELIEF_TRY(const Unwrapped flat, unwrap(mesh));
    RELIEF_TRY(mesh::Triangulation base, triangulation_of(flat.mesh));
    PsValues values;
    values.components.resize(3);
    for (const std::int32_t vertex : flat.origin)
        for (std::size_t m = 0; m < 3; ++m)
            values.components[m].push_back(mesh.vertices[static_cast<std::size_t>(vertex)][m]);
    return PsModel{std::move(base), std::move(values)};
}

Status check_in_space(int components) {
    if (components != 2) return {};
    return Error{ErrorCode::Unsupported,
                 "two components are no surface in space; decode them as a raster or .csv", ""};
}

std::array<double, 3> in_space(Vec2 place, std::span<const double> values) {
    if (values.size() == 3) return {values[0], values[1], values[2]};
    return {place.x, place.y, values[0]};
}

Result<std::vector<ps::TangentPlanes>> tangent_planes_of(const PsFile& file,
                                                         const PsSurface& level) {
    std::vector<ps::TangentPlanes> components;
    for (const ps::Coefficients& spline : level.components)
        components.push_back(ps::tangent_planes(level.space, spline));
    if (!file.holds_values() || file.edited()) return components;
    RELIEF_TRY(const PsValues exact, file.values());
    for (std::size_t m = 0; m < components.size(); ++m)
        for (std::size_t v = 0; v < components[m].size(); ++v)
            components[m][v].value = exact.components[m][v];
    return components;
}

Result<PolygonMesh> polygons_of(const PsFile& file, const PsSurface& level) {
    RELIEF_CHECK(check_in_space(file.components()));
    RELIEF_TRY(const auto components, tangent_planes_of(file, level));
    const mesh::Triangulation& mesh = level.space.mesh;
    PolygonMesh polygons;
    MeshAttribute parameters{"uv", 2};
    std::vector<double> values(components.size());
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        for (std::size_t m = 0; m < components.size(); ++m) values[m] = components[m][v].value;
        const Vec2 place = mesh.origin + mesh.vertex(v);
        polygons.vertices.push_back(in_space(place, values));
        parameters.values.insert(parameters.values.end(), {place.x, place.y});
    }
    if (components.size() == 3) polygons.attributes.push_back(std::move(parameters));
    for (const auto& triangle : mesh.triangles) {
        std::array<std::int32_t, 3> corners{};
        std::copy(triangle.begin(), triangle.end(), corners.begin());
        polygons.add_polygon(corners);
    }
    return polygons;
}

}  // namespace relief::codec
