#pragma once

#include <string>
#include <vector>

#include "contest.h"
#include "field.h"
#include "relief/codec/raster_codec.h"

/// The codecs of the comparison behind one interface: from memory to memory, in the calling thread.
namespace relief::peers {

using codec::Goal;

class Peer : public Contestant {
  public:
    /// Whether encode can reach such a goal with such samples.
    [[nodiscard]] virtual bool offers(const Field& field, const Goal& goal) const = 0;
    /// Whether the bytes tell holes from samples.
    [[nodiscard]] virtual bool has_mask() const { return false; }

    /// Errors: BadInput when the codec refuses.
    [[nodiscard]] virtual Result<Bytes> encode(const Field& field, const Goal& goal) const = 0;
    /// Size, type, range and goal, a few bytes, may be taken from `about` and `goal`: peers do not
    /// pay for a header. Errors: BadFile when the codec refuses.
    [[nodiscard]] virtual Result<Decoded> decode(const Bytes& bytes, const Field& about,
                                                 const Goal& goal) const = 0;

    [[nodiscard]] virtual bool has_windows() const { return false; }
    /// The samples of a window alone.
    [[nodiscard]] virtual Result<Decoded> decode_window(const Bytes& bytes, const Field& about,
                                                        const LatticeBox& window) const;
};

/// A library that the comparison knows.
struct Library {
    std::string name;
    std::string version;  ///< empty: not installed when this program was built
};

using Peers = Contestants<Peer>;

[[nodiscard]] Peers relief_codecs();
[[nodiscard]] Peers gdal_peers();
#ifdef RELIEF_PEER_LERC
[[nodiscard]] Peers lerc_peers();
#endif
#ifdef RELIEF_PEER_OPENJPEG
[[nodiscard]] Peers openjpeg_peers();
#endif
#ifdef RELIEF_PEER_JXL
[[nodiscard]] Peers jxl_peers();
#endif
#ifdef RELIEF_PEER_ZFP
[[nodiscard]] Peers zfp_peers();
#endif

/// All that were built, relief first.
[[nodiscard]] Peers all_peers();
[[nodiscard]] std::vector<Library> libraries();

/// The largest error that the goal allows: infinite if it does not say.
[[nodiscard]] double bound_of(const Goal& goal);
/// That a codec refused, in the words of `Error`.
[[nodiscard]] Error refused(ErrorCode code, const std::string& what);

}  // namespace relief::peers
