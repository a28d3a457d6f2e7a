#pragma once

#include <string>
#include <vector>

#include "contest.h"
#include "relief/core/vec3.h"
#include "relief/mesh/topology.h"
#include "relief/multires/subdivision_rules.h"

/// Libraries that subdivide meshes, behind one interface: from a list of faces and points to
/// another one, in the calling thread.
namespace relief::peers {

using multires::MeshScheme;

/// A mesh as all libraries take and give it.
struct Polygons {
    mesh::FaceList faces;
    std::vector<Vec3<double>> points;
};

/// A base mesh and what is to become of it.
struct Subdividing {
    const Polygons& base;
    MeshScheme scheme = MeshScheme::Loop;
    int steps = 1;
};

/// Seconds that a subdivision took on the clock of its thread. Each number also has what the
/// library needs for it: building its own mesh of the base is not counted where it is made before.
struct SubdivisionTimes {
    double first = 0;   ///< faces and points into fresh memory
    double kept = 0;    ///< the same once more, into the memory of the call before; 0: not offered
    double points = 0;  ///< the points alone, again; 0: not offered
};

class MeshPeer : public Contestant {
  public:
    /// Scalars that it keeps points in.
    [[nodiscard]] virtual std::string scalar() const = 0;
    [[nodiscard]] virtual bool offers(MeshScheme scheme) const = 0;

    /// Errors: BadInput when the library refuses the base.
    [[nodiscard]] virtual Result<SubdivisionTimes> measure(const Subdividing& task) const = 0;
    [[nodiscard]] virtual Result<Polygons> result(const Subdividing& task) const = 0;
};

using MeshPeers = Contestants<MeshPeer>;

[[nodiscard]] MeshPeers relief_meshes();
#ifdef RELIEF_PEER_OPENSUBDIV
[[nodiscard]] MeshPeers opensubdiv_peers();
#endif
#ifdef RELIEF_PEER_OPENMESH
[[nodiscard]] MeshPeers openmesh_peers();
#endif
#ifdef RELIEF_PEER_CGAL
[[nodiscard]] MeshPeers cgal_peers();
#endif

/// All that were built, relief first.
[[nodiscard]] MeshPeers all_mesh_peers();

}  // namespace relief::peers
