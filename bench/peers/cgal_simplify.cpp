#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "simplify_peer.h"

namespace relief::peers {

namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;

bool build(const PolygonMesh& from, SurfaceMesh& mesh) {
    std::vector<SurfaceMesh::Vertex_index> vertices;
    for (const auto& [x, y, z] : from.vertices) vertices.push_back(mesh.add_vertex(Point(x, y, z)));
    for (std::int64_t f = 0; f < from.polygon_count(); ++f) {
        std::vector<SurfaceMesh::Vertex_index> corners;
        for (const std::int32_t v : from.polygon(f))
            corners.push_back(vertices[static_cast<std::size_t>(v)]);
        if (corners.size() != 3 || mesh.add_face(corners) == SurfaceMesh::null_face()) return false;
    }
    return true;
}

/// What is left, numbered anew.
PolygonMesh polygons_of(const SurfaceMesh& mesh) {
    PolygonMesh result;
    std::vector<std::int32_t> numbers(mesh.num_vertices(), -1);
    for (const auto v : mesh.vertices()) {
        const Point& p = mesh.point(v);
        numbers[v] = static_cast<std::int32_t>(result.vertices.size());
        result.vertices.push_back({p.x(), p.y(), p.z()});
    }
    for (const auto face : mesh.faces()) {
        std::vector<std::int32_t> corners;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(face)))
            corners.push_back(numbers[v]);
        result.add_polygon(corners);
    }
    return result;
}

}  // namespace

Simplified cgal_simplified(const PolygonMesh& mesh, std::span<const std::int64_t> faces) {
    SurfaceMesh surface;
    if (!build(mesh, surface)) return Error{ErrorCode::BadInput, "CGAL refuses the mesh", ""};
    std::vector<PolygonMesh> results;
    for (const std::int64_t count : faces) {
        namespace Simplification = CGAL::Surface_mesh_simplification;
        // A closed mesh has one and a half times as many edges as faces.
        const auto edges = static_cast<std::size_t>(count + count / 2);
        Simplification::edge_collapse(surface,
                                      Simplification::Count_stop_predicate<SurfaceMesh>(edges));
        surface.collect_garbage();
        results.push_back(polygons_of(surface));
    }
    return results;
}

}  // namespace relief::peers
