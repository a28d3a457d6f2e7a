#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/CatmullClarkT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/LoopT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/Sqrt3T.hh>

#include "mesh_peer.h"

namespace relief::peers {

namespace {

namespace Uniform = OpenMesh::Subdivider::Uniform;
using Triangles = OpenMesh::TriMesh_ArrayKernelT<>;
using AnyFaces = OpenMesh::PolyMesh_ArrayKernelT<>;

template <class Mesh>
bool build(const Polygons& base, Mesh& mesh) {
    std::vector<typename Mesh::VertexHandle> vertices;
    for (const auto& p : base.points)
        vertices.push_back(mesh.add_vertex(
            {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}));
    for (std::size_t f = 0; f < base.faces.size(); ++f) {
        std::vector<typename Mesh::VertexHandle> corners;
        for (const mesh::Index v : base.faces[f]) corners.push_back(vertices[v]);
        if (!mesh.add_face(corners).is_valid()) return false;
    }
    return true;
}

template <class Mesh>
Polygons polygons_of(const Mesh& mesh) {
    Polygons result;
    for (const auto v : mesh.vertices()) {
        const auto& p = mesh.point(v);
        result.points.push_back({p[0], p[1], p[2]});
    }
    for (const auto f : mesh.faces()) {
        std::vector<mesh::Index> corners;
        for (const auto v : mesh.fv_range(f)) corners.push_back(static_cast<mesh::Index>(v.idx()));
        result.faces.add(corners);
    }
    return result;
}

/// With the subdivider S of meshes M; seconds: what subdividing took.
template <class M, class S>
Result<Polygons> subdivided(const Subdividing& task, double& seconds, bool wanted) {
    M mesh;
    S subdivider;
    if (!build(task.base, mesh)) return Error{ErrorCode::BadInput, "OpenMesh refuses the mesh", ""};
    seconds = -thread_seconds();
    subdivider.attach(mesh);
    subdivider(static_cast<std::size_t>(task.steps));
    subdivider.detach();
    seconds += thread_seconds();
    return wanted ? polygons_of(mesh) : Polygons();
}

class OpenMeshPeer final : public MeshPeer {
  public:
    [[nodiscard]] std::string name() const override { return "OpenMesh"; }
    [[nodiscard]] std::string scalar() const override { return "float"; }
    [[nodiscard]] bool offers(MeshScheme) const override { return true; }

    [[nodiscard]] Result<SubdivisionTimes> measure(const Subdividing& task) const override {
        SubdivisionTimes times;
        RELIEF_TRY(const Polygons nothing, run(task, times.first, false));
        static_cast<void>(nothing);
        return times;
    }
    [[nodiscard]] Result<Polygons> result(const Subdividing& task) const override {
        double seconds = 0;
        return run(task, seconds, true);
    }

  private:
    static Result<Polygons> run(const Subdividing& task, double& seconds, bool wanted) {
        if (task.scheme == MeshScheme::CatmullClark)
            return subdivided<AnyFaces, Uniform::CatmullClarkT<AnyFaces>>(task, seconds, wanted);
        if (task.scheme == MeshScheme::Loop)
            return subdivided<Triangles, Uniform::LoopT<Triangles>>(task, seconds, wanted);
        return subdivided<Triangles, Uniform::Sqrt3T<Triangles>>(task, seconds, wanted);
    }
};

}  // namespace

MeshPeers openmesh_peers() {
    MeshPeers peers;
    peers.push_back(std::make_unique<OpenMeshPeer>());
    return peers;
}

}  // namespace relief::peers
