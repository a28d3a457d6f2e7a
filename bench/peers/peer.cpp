#include "peer.h"

#include <limits>

namespace relief::peers {

Result<Decoded> Peer::decode_window(const Bytes&, const Field&, const LatticeBox&) const {
    return Error{ErrorCode::Unsupported, name() + " decodes whole rasters only", ""};
}

double bound_of(const Goal& goal) {
    if (goal.kind == Goal::Kind::Lossless) return 0;
    if (goal.kind == Goal::Kind::MaxError) return goal.value;
    return std::numeric_limits<double>::infinity();
}

Error refused(ErrorCode code, const std::string& what) {
    return {code, what + " failed", ""};
}

Peers all_peers() {
    Peers all = relief_codecs();
    append(all, gdal_peers());
#ifdef RELIEF_PEER_LERC
    append(all, lerc_peers());
#endif
#ifdef RELIEF_PEER_OPENJPEG
    append(all, openjpeg_peers());
#endif
#ifdef RELIEF_PEER_JXL
    append(all, jxl_peers());
#endif
#ifdef RELIEF_PEER_ZFP
    append(all, zfp_peers());
#endif
    return all;
}

std::vector<Library> libraries() {
    return {{"GDAL", RELIEF_GDAL_VERSION},
            {"LERC", RELIEF_LERC_VERSION},
            {"OpenJPEG", RELIEF_OPENJPEG_VERSION},
            {"JPEG XL", RELIEF_JXL_VERSION},
            {"zfp", RELIEF_ZFP_VERSION}};
}

}  // namespace relief::peers
