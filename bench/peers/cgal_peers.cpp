#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/helpers.h>
#include <CGAL/subdivision_method_3.h>

#include "mesh_peer.h"

namespace relief::peers {

namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;

bool build(const Polygons& base, SurfaceMesh& mesh) {
    std::vector<SurfaceMesh::Vertex_index> vertices;
    for (const auto& p : base.points) vertices.push_back(mesh.add_vertex(Point(p.x, p.y, p.z)));
    for (std::size_t f = 0; f < base.faces.size(); ++f) {
        std::vector<SurfaceMesh::Vertex_index> corners;
        for (const mesh::Index v : base.faces[f]) corners.push_back(vertices[v]);
        if (mesh.add_face(corners) == SurfaceMesh::null_face()) return false;
    }
    return true;
}

Polygons polygons_of(const SurfaceMesh& mesh) {
    Polygons result;
    for (const auto v : mesh.vertices()) {
        const Point& p = mesh.point(v);
        result.points.push_back({p.x(), p.y(), p.z()});
    }
    for (const auto f : mesh.faces()) {
        std::vector<mesh::Index> corners;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) corners.push_back(v);
        result.faces.add(corners);
    }
    return result;
}

class CgalPeer final : public MeshPeer {
  public:
    [[nodiscard]] std::string name() const override { return "CGAL"; }
    [[nodiscard]] std::string scalar() const override { return "double"; }
    [[nodiscard]] bool offers(MeshScheme) const override { return true; }

    [[nodiscard]] Result<SubdivisionTimes> measure(const Subdividing& task) const override {
        SurfaceMesh mesh;
        SubdivisionTimes times;
        RELIEF_CHECK(run(task, mesh, times.first));
        return times;
    }
    [[nodiscard]] Result<Polygons> result(const Subdividing& task) const override {
        SurfaceMesh mesh;
        double seconds = 0;
        RELIEF_CHECK(run(task, mesh, seconds));
        return polygons_of(mesh);
    }

  private:
    static Status run(const Subdividing& task, SurfaceMesh& mesh, double& seconds) {
        if (!build(task.base, mesh)) return Error{ErrorCode::BadInput, "CGAL refuses the mesh", ""};
        const auto steps = CGAL::parameters::number_of_iterations(task.steps);
        seconds = -thread_seconds();
        if (task.scheme == MeshScheme::Loop)
            CGAL::Subdivision_method_3::Loop_subdivision(mesh, steps);
        else if (task.scheme == MeshScheme::CatmullClark)
            CGAL::Subdivision_method_3::CatmullClark_subdivision(mesh, steps);
        else
            CGAL::Subdivision_method_3::Sqrt3_subdivision(mesh, steps);
        seconds += thread_seconds();
        return {};
    }
};

}  // namespace

MeshPeers cgal_peers() {
    MeshPeers peers;
    peers.push_back(std::make_unique<CgalPeer>());
    return peers;
}

}  // namespace relief::peers
