#include <openjpeg.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "peer.h"

namespace relief::peers {

namespace {

struct StreamDestroy {
    void operator()(opj_stream_t* stream) const { opj_stream_destroy(stream); }
};
struct CodecDestroy {
    void operator()(opj_codec_t* codec) const { opj_destroy_codec(codec); }
};
struct ImageDestroy {
    void operator()(opj_image_t* image) const { opj_image_destroy(image); }
};
using Stream = std::unique_ptr<opj_stream_t, StreamDestroy>;
using Codec = std::unique_ptr<opj_codec_t, CodecDestroy>;
using Image = std::unique_ptr<opj_image_t, ImageDestroy>;

/// A file in memory, for OpenJPEG's callbacks.
struct MemoryFile {
    Bytes bytes;
    std::size_t at = 0;

    static OPJ_SIZE_T read(void* buffer, OPJ_SIZE_T size, void* self) {
        auto& file = *static_cast<MemoryFile*>(self);
        const std::size_t n = std::min<std::size_t>(size, file.bytes.size() - file.at);
        if (n == 0) return static_cast<OPJ_SIZE_T>(-1);
        std::memcpy(buffer, file.bytes.data() + file.at, n);
        file.at += n;
        return n;
    }
    static OPJ_SIZE_T write(void* buffer, OPJ_SIZE_T size, void* self) {
        auto& file = *static_cast<MemoryFile*>(self);
        file.bytes.resize(std::max(file.bytes.size(), file.at + size));
        std::memcpy(file.bytes.data() + file.at, buffer, size);
        file.at += size;
        return size;
    }
    static OPJ_BOOL seek(OPJ_OFF_T place, void* self) {
        auto& file = *static_cast<MemoryFile*>(self);
        if (static_cast<std::size_t>(place) > file.bytes.size()) return OPJ_FALSE;
        file.at = static_cast<std::size_t>(place);
        return OPJ_TRUE;
    }
    static OPJ_OFF_T skip(OPJ_OFF_T distance, void* self) {
        const auto from = static_cast<OPJ_OFF_T>(static_cast<MemoryFile*>(self)->at);
        return seek(from + distance, self) ? distance : -1;
    }
};

Stream open_stream(MemoryFile& file, bool input) {
    Stream stream(opj_stream_default_create(input));
    opj_stream_set_user_data(stream.get(), &file, nullptr);
    opj_stream_set_user_data_length(stream.get(), file.bytes.size());
    opj_stream_set_read_function(stream.get(), MemoryFile::read);
    opj_stream_set_write_function(stream.get(), MemoryFile::write);
    opj_stream_set_seek_function(stream.get(), MemoryFile::seek);
    opj_stream_set_skip_function(stream.get(), MemoryFile::skip);
    return stream;
}

/// One tile, one layer, 64 x 64 blocks, up to 7 resolutions. rate 0: reversible.
Result<Bytes> encode_image(opj_image_t& image, float rate) {
    opj_cparameters_t parameters;
    opj_set_default_encoder_parameters(&parameters);
    parameters.irreversible = rate > 0;
    parameters.tcp_numlayers = 1;
    parameters.tcp_rates[0] = rate;
    parameters.cp_disto_alloc = 1;
    parameters.numresolution = 7;
    const OPJ_UINT32 side = std::min(image.x1, image.y1);
    while (parameters.numresolution > 1 && (side >> (parameters.numresolution - 1)) == 0)
        --parameters.numresolution;
    const Codec codec(opj_create_compress(OPJ_CODEC_J2K));
    MemoryFile file;
    const Stream stream = open_stream(file, false);
    if (!opj_setup_encoder(codec.get(), &parameters, &image) ||
        !opj_start_compress(codec.get(), &image, stream.get()) ||
        !opj_encode(codec.get(), stream.get()) || !opj_end_compress(codec.get(), stream.get()))
        return refused(ErrorCode::BadInput, "OpenJPEG encoding");
    return std::move(file.bytes);
}

Image new_image(const Field& field, bool is_signed) {
    opj_image_cmptparm_t component{};
    component.dx = component.dy = 1;
    component.w = static_cast<OPJ_UINT32>(field.cols());
    component.h = static_cast<OPJ_UINT32>(field.rows());
    component.prec = 16;
    component.sgnd = is_signed;
    Image image(opj_image_create(1, &component, OPJ_CLRSPC_GRAY));
    image->x1 = component.w;
    image->y1 = component.h;
    return image;
}

Result<Image> decode_image(const Bytes& bytes, const LatticeBox& window) {
    MemoryFile file{bytes};
    const Stream stream = open_stream(file, true);
    const Codec codec(opj_create_decompress(OPJ_CODEC_J2K));
    opj_dparameters_t parameters;
    opj_set_default_decoder_parameters(&parameters);
    opj_image_t* image = nullptr;
    const bool begun = opj_setup_decoder(codec.get(), &parameters) &&
                       opj_read_header(stream.get(), codec.get(), &image);
    Image decoded(image);
    if (!begun ||
        !opj_set_decode_area(codec.get(), image, static_cast<OPJ_INT32>(window.col0),
                             static_cast<OPJ_INT32>(window.row0),
                             static_cast<OPJ_INT32>(window.col0 + window.cols),
                             static_cast<OPJ_INT32>(window.row0 + window.rows)) ||
        !opj_decode(codec.get(), stream.get(), image))
        return refused(ErrorCode::BadFile, "OpenJPEG decoding");
    return decoded;
}

/// Without loss int16 as it is; for a size any samples, stretched to 16 bits.
class Jpeg2000 final : public Peer {
  public:
    [[nodiscard]] std::string name() const override { return "JPEG 2000"; }
    [[nodiscard]] bool offers(const Field& field, const Goal& goal) const override {
        return goal.kind == Goal::Kind::Bytes ||
               (goal.kind == Goal::Kind::Lossless && field.integer());
    }
    [[nodiscard]] bool has_windows() const override { return true; }

    [[nodiscard]] Result<Bytes> encode(const Field& field, const Goal& goal) const override {
        const bool sized = goal.kind == Goal::Kind::Bytes;
        const Image image = new_image(field, !sized);
        const double scale = sized ? stretch(field) : 1;
        const double origin = sized ? field.lowest : 0;
        OPJ_INT32* to = image->comps[0].data;
        std::visit(
            [&](const auto& values) {
                for (const auto value : values)
                    *to++ = static_cast<OPJ_INT32>(std::nearbyint((value - origin) * scale));
            },
            field.values);
        const double plain = 2 * static_cast<double>(field.count());
        return encode_image(*image, sized ? static_cast<float>(plain / goal.value) : 0);
    }

    [[nodiscard]] Result<Decoded> decode(const Bytes& bytes, const Field& about,
                                         const Goal& goal) const override {
        RELIEF_TRY(const Image image,
                   decode_image(bytes, {0, 0, about.raster.rows, about.raster.cols}));
        return decoded(*image, about, goal);
    }

    [[nodiscard]] Result<Decoded> decode_window(const Bytes& bytes, const Field& about,
                                                const LatticeBox& window) const override {
        RELIEF_TRY(const Image image, decode_image(bytes, window));
        return decoded(*image, about, {Goal::Kind::Lossless, 0});
    }

  private:
    static double stretch(const Field& field) {
        return field.highest > field.lowest ? 65535 / (field.highest - field.lowest) : 1;
    }

    static Decoded decoded(const opj_image_t& image, const Field& about, const Goal& goal) {
        const OPJ_INT32* from = image.comps[0].data;
        const std::size_t count = std::size_t{image.comps[0].w} * image.comps[0].h;
        if (goal.kind == Goal::Kind::Lossless) return std::vector<std::int16_t>(from, from + count);
        const double scale = stretch(about);
        std::vector<float> values;
        values.reserve(count);
        for (std::size_t k = 0; k < count; ++k) {
            const double value = about.lowest + from[k] / scale;
            values.push_back(static_cast<float>(about.integer() ? std::nearbyint(value) : value));
        }
        return values;
    }
};

}  // namespace

Peers openjpeg_peers() {
    Peers all;
    all.push_back(std::make_unique<Jpeg2000>());
    return all;
}

}  // namespace relief::peers
