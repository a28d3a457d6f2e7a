#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include "simplify_peer.h"

namespace relief::peers {

namespace {

struct DoublePlaces : OpenMesh::DefaultTraits {
    using Point = OpenMesh::Vec3d;
    using Normal = OpenMesh::Vec3d;
};
using Triangles = OpenMesh::TriMesh_ArrayKernelT<DoublePlaces>;
using Decimater = OpenMesh::Decimater::DecimaterT<Triangles>;

bool build(const PolygonMesh& from, Triangles& mesh) {
    std::vector<Triangles::VertexHandle> vertices;
    for (const auto& [x, y, z] : from.vertices) vertices.push_back(mesh.add_vertex({x, y, z}));
    for (std::int64_t f = 0; f < from.polygon_count(); ++f) {
        std::vector<Triangles::VertexHandle> corners;
        for (const std::int32_t v : from.polygon(f))
            corners.push_back(vertices[static_cast<std::size_t>(v)]);
        if (!mesh.add_face(corners).is_valid()) return false;
    }
    return true;
}

/// What is left, numbered anew.
PolygonMesh polygons_of(const Triangles& mesh) {
    PolygonMesh result;
    std::vector<std::int32_t> numbers(mesh.n_vertices(), -1);
    for (const auto face : mesh.faces()) {
        std::vector<std::int32_t> corners;
        for (const auto v : mesh.fv_range(face)) {
            std::int32_t& number = numbers[static_cast<std::size_t>(v.idx())];
            if (number < 0) {
                number = static_cast<std::int32_t>(result.vertices.size());
                const auto& p = mesh.point(v);
                result.vertices.push_back({p[0], p[1], p[2]});
            }
            corners.push_back(number);
        }
        result.add_polygon(corners);
    }
    return result;
}

}  // namespace

Simplified openmesh_simplified(const PolygonMesh& mesh, std::span<const std::int64_t> faces) {
    Triangles triangles;
    triangles.request_face_normals();
    triangles.request_vertex_status();
    triangles.request_edge_status();
    triangles.request_halfedge_status();
    triangles.request_face_status();
    if (!build(mesh, triangles)) return Error{ErrorCode::BadInput, "OpenMesh refuses the mesh", ""};
    triangles.update_face_normals();
    for (const auto v : triangles.vertices())
        triangles.status(v).set_locked(triangles.is_boundary(v));
    Decimater decimater(triangles);
    OpenMesh::Decimater::ModQuadricT<Triangles>::Handle quadrics;
    OpenMesh::Decimater::ModNormalFlippingT<Triangles>::Handle flipping;
    decimater.add(quadrics);
    decimater.module(quadrics).unset_max_err();
    decimater.add(flipping);
    if (!decimater.initialize())
        return Error{ErrorCode::BadInput, "OpenMesh can not simplify the mesh", ""};
    std::vector<PolygonMesh> results;
    for (const std::int64_t count : faces) {
        decimater.decimate_to_faces(0, static_cast<std::size_t>(count));
        results.push_back(polygons_of(triangles));
    }
    return results;
}

}  // namespace relief::peers
