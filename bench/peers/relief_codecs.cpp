#include <utility>

#include "peer.h"

namespace relief::peers {

namespace {

/// The library itself: the closed loop for bounds, the open loop for sizes.
class Relief final : public Peer {
  public:
    Relief(std::string name, codec::Profile profile, bool sizes)
        : name_(std::move(name)), profile_(profile), sizes_(sizes) {}

    [[nodiscard]] std::string name() const override { return name_; }
    [[nodiscard]] bool offers(const Field&, const Goal& goal) const override {
        return (goal.kind == Goal::Kind::Bytes) == sizes_;
    }
    [[nodiscard]] bool has_mask() const override { return true; }
    [[nodiscard]] bool has_windows() const override { return !sizes_; }

    [[nodiscard]] Result<Bytes> encode(const Field& field, const Goal& goal) const override {
        codec::EncodeOptions options;
        options.goal = goal;
        options.profile = profile_;
        RELIEF_TRY(codec::EncodedRaster encoded, codec::encode_raster(field.raster, options));
        return std::move(encoded.bytes);
    }

    [[nodiscard]] Result<Decoded> decode(const Bytes& bytes, const Field&,
                                         const Goal&) const override {
        RELIEF_TRY(const codec::RasterFile file, codec::RasterFile::open(bytes));
        RELIEF_TRY(Raster raster, file.decode(0));
        return Decoded(std::move(raster));
    }

    [[nodiscard]] Result<Decoded> decode_window(const Bytes& bytes, const Field&,
                                                const LatticeBox& window) const override {
        RELIEF_TRY(const codec::RasterFile file, codec::RasterFile::open(bytes));
        RELIEF_TRY(codec::DecodedRaster part, file.decode_window(0, window));
        return Decoded(std::move(part.raster));
    }

  private:
    std::string name_;
    codec::Profile profile_;
    bool sizes_;
};

}  // namespace

Peers relief_codecs() {
    Peers all;
    all.push_back(std::make_unique<Relief>("relief dense", codec::Profile::Dense, false));
    all.push_back(std::make_unique<Relief>("relief fast", codec::Profile::Fast, false));
    all.push_back(std::make_unique<Relief>("relief open", codec::Profile::Dense, true));
    return all;
}

}  // namespace relief::peers
