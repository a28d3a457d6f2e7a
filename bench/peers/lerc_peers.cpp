#include <Lerc_c_api.h>
#include <zstd.h>

#include "peer.h"

namespace relief::peers {

namespace {

/// GDAL's level for LERC_ZSTD.
constexpr int kZstdLevel = 9;

template <class T>
constexpr unsigned kLercType = 0;
template <>
constexpr unsigned kLercType<std::int16_t> = 2;
template <>
constexpr unsigned kLercType<float> = 6;

template <class T>
Result<Bytes> encode_lerc(const Field& field, const std::vector<T>& values, double bound) {
    const auto cols = static_cast<int>(field.cols());
    const auto rows = static_cast<int>(field.rows());
    const bool holes = !field.valid.empty();
    Bytes bytes(field.count() * sizeof(T) + field.count() / 4 + 1024);
    unsigned written = 0;
    if (lerc_encode(values.data(), kLercType<T>, 1, cols, rows, 1, holes ? 1 : 0,
                    holes ? field.valid.data() : nullptr, bound, bytes.data(),
                    static_cast<unsigned>(bytes.size()), &written) != 0)
        return refused(ErrorCode::BadInput, "lerc_encode");
    bytes.resize(written);
    return bytes;
}

template <class T>
Result<Decoded> decode_lerc(const Bytes& bytes, const Field& about) {
    std::vector<T> values(about.count());
    std::vector<std::uint8_t> valid(about.valid.size());
    if (lerc_decode(bytes.data(), static_cast<unsigned>(bytes.size()), valid.empty() ? 0 : 1,
                    valid.empty() ? nullptr : valid.data(), 1, static_cast<int>(about.cols()),
                    static_cast<int>(about.rows()), 1, kLercType<T>, values.data()) != 0)
        return refused(ErrorCode::BadFile, "lerc_decode");
    return Decoded(std::move(values));
}

class Lerc : public Peer {
  public:
    [[nodiscard]] std::string name() const override { return "LERC"; }
    [[nodiscard]] bool offers(const Field&, const Goal& goal) const override {
        return goal.kind != Goal::Kind::Bytes;
    }
    [[nodiscard]] bool has_mask() const override { return true; }

    [[nodiscard]] Result<Bytes> encode(const Field& field, const Goal& goal) const override {
        return std::visit(
            [&](const auto& values) { return encode_lerc(field, values, bound_of(goal)); },
            field.values);
    }
    [[nodiscard]] Result<Decoded> decode(const Bytes& bytes, const Field& about,
                                         const Goal&) const override {
        return about.integer() ? decode_lerc<std::int16_t>(bytes, about)
                               : decode_lerc<float>(bytes, about);
    }
};

/// What GDAL's LERC_ZSTD writes for a tile, with one tile for all.
class LercZstd final : public Lerc {
  public:
    [[nodiscard]] std::string name() const override { return "LERC+ZSTD"; }

    [[nodiscard]] Result<Bytes> encode(const Field& field, const Goal& goal) const override {
        RELIEF_TRY(const Bytes plain, Lerc::encode(field, goal));
        Bytes bytes(ZSTD_compressBound(plain.size()));
        const std::size_t size =
            ZSTD_compress(bytes.data(), bytes.size(), plain.data(), plain.size(), kZstdLevel);
        if (ZSTD_isError(size)) return refused(ErrorCode::BadInput, "ZSTD_compress");
        bytes.resize(size);
        return bytes;
    }
    [[nodiscard]] Result<Decoded> decode(const Bytes& bytes, const Field& about,
                                         const Goal& goal) const override {
        Bytes plain(ZSTD_getFrameContentSize(bytes.data(), bytes.size()));
        const std::size_t size =
            ZSTD_decompress(plain.data(), plain.size(), bytes.data(), bytes.size());
        if (ZSTD_isError(size)) return refused(ErrorCode::BadFile, "ZSTD_decompress");
        return Lerc::decode(plain, about, goal);
    }
};

}  // namespace

Peers lerc_peers() {
    Peers all;
    all.push_back(std::make_unique<Lerc>());
    all.push_back(std::make_unique<LercZstd>());
    return all;
}

}  // namespace relief::peers
