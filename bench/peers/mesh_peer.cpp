#include "mesh_peer.h"

namespace relief::peers {

MeshPeers all_mesh_peers() {
    MeshPeers all = relief_meshes();
#ifdef RELIEF_PEER_OPENSUBDIV
    append(all, opensubdiv_peers());
#endif
#ifdef RELIEF_PEER_OPENMESH
    append(all, openmesh_peers());
#endif
#ifdef RELIEF_PEER_CGAL
    append(all, cgal_peers());
#endif
    return all;
}

}  // namespace relief::peers
