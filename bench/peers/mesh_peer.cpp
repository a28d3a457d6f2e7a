#include "mesh_peer.h"

#include <iterator>

namespace relief::peers {

MeshPeers all_mesh_peers() {
    MeshPeers all = relief_meshes();
    [[maybe_unused]] const auto add = [&all](MeshPeers some) {
        all.insert(all.end(), std::make_move_iterator(some.begin()),
                   std::make_move_iterator(some.end()));
    };
#ifdef RELIEF_PEER_OPENSUBDIV
    add(opensubdiv_peers());
#endif
#ifdef RELIEF_PEER_OPENMESH
    add(openmesh_peers());
#endif
#ifdef RELIEF_PEER_CGAL
    add(cgal_peers());
#endif
    return all;
}

}  // namespace relief::peers
