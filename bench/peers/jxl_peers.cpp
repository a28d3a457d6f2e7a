#include <jxl/decode_cxx.h>
#include <jxl/encode_cxx.h>

#include <cmath>
#include <limits>

#include "peer.h"

namespace relief::peers {

namespace {

constexpr int kEffort = 7;

/// An image of one channel, samples in the machine's byte order.
struct Image {
    std::size_t cols = 0;
    std::size_t rows = 0;
    bool floats = false;  ///< float32; else uint16

    [[nodiscard]] JxlPixelFormat format() const {
        return {1, floats ? JXL_TYPE_FLOAT : JXL_TYPE_UINT16, JXL_NATIVE_ENDIAN, 0};
    }
    [[nodiscard]] std::size_t size() const { return rows * cols * (floats ? 4 : 2); }
};

bool set_lossless_grey(JxlEncoder* encoder, const Image& image) {
    JxlBasicInfo info;
    JxlEncoderInitBasicInfo(&info);
    info.xsize = static_cast<std::uint32_t>(image.cols);
    info.ysize = static_cast<std::uint32_t>(image.rows);
    info.bits_per_sample = image.floats ? 32 : 16;
    info.exponent_bits_per_sample = image.floats ? 8 : 0;
    info.num_color_channels = 1;
    info.uses_original_profile = JXL_TRUE;
    JxlColorEncoding grey;
    JxlColorEncodingSetToSRGB(&grey, JXL_TRUE);
    return JxlEncoderSetCodestreamLevel(encoder, 10) == JXL_ENC_SUCCESS &&
           JxlEncoderSetBasicInfo(encoder, &info) == JXL_ENC_SUCCESS &&
           JxlEncoderSetColorEncoding(encoder, &grey) == JXL_ENC_SUCCESS;
}

/// Appends what the encoder has to say.
bool drain(JxlEncoder* encoder, Bytes& bytes) {
    bytes.resize(std::size_t{1} << 16);
    std::uint8_t* next = bytes.data();
    for (;;) {
        std::size_t room = bytes.size() - static_cast<std::size_t>(next - bytes.data());
        const JxlEncoderStatus status = JxlEncoderProcessOutput(encoder, &next, &room);
        const auto used = static_cast<std::size_t>(next - bytes.data());
        if (status == JXL_ENC_NEED_MORE_OUTPUT) {
            bytes.resize(2 * bytes.size());
            next = bytes.data() + used;
            continue;
        }
        bytes.resize(used);
        return status == JXL_ENC_SUCCESS;
    }
}

Result<Bytes> encode_image(const Image& image, const void* samples) {
    const JxlEncoderPtr encoder = JxlEncoderMake(nullptr);
    const bool ready = set_lossless_grey(encoder.get(), image);
    JxlEncoderFrameSettings* frame = JxlEncoderFrameSettingsCreate(encoder.get(), nullptr);
    const JxlPixelFormat format = image.format();
    Bytes bytes;
    if (!ready || JxlEncoderSetFrameLossless(frame, JXL_TRUE) != JXL_ENC_SUCCESS ||
        JxlEncoderFrameSettingsSetOption(frame, JXL_ENC_FRAME_SETTING_EFFORT, kEffort) !=
            JXL_ENC_SUCCESS ||
        JxlEncoderAddImageFrame(frame, &format, samples, image.size()) != JXL_ENC_SUCCESS)
        return refused(ErrorCode::BadInput, "setting up the JPEG XL encoder");
    JxlEncoderCloseInput(encoder.get());
    if (!drain(encoder.get(), bytes)) return refused(ErrorCode::BadInput, "JPEG XL encoding");
    return bytes;
}

Status decode_image(const Bytes& bytes, const Image& image, void* samples) {
    const JxlDecoderPtr decoder = JxlDecoderMake(nullptr);
    const JxlPixelFormat format = image.format();
    JxlDecoderSubscribeEvents(decoder.get(), JXL_DEC_FULL_IMAGE);
    JxlDecoderSetInput(decoder.get(), bytes.data(), bytes.size());
    JxlDecoderCloseInput(decoder.get());
    for (;;) {
        const JxlDecoderStatus status = JxlDecoderProcessInput(decoder.get());
        if (status == JXL_DEC_FULL_IMAGE) return {};
        if (status != JXL_DEC_NEED_IMAGE_OUT_BUFFER ||
            JxlDecoderSetImageOutBuffer(decoder.get(), &format, samples, image.size()) !=
                JXL_DEC_SUCCESS)
            return refused(ErrorCode::BadFile, "JPEG XL decoding");
    }
}

/// Samples are origin + step x index: the plainest way to keep a bound.
class Quantiser {
  public:
    Quantiser(const Field& field, double bound)
        : step_(field.integer() ? 2 * std::floor(bound) + 1 : 2 * bound),
          origin_(field.integer() ? field.lowest : step_ * std::nearbyint(field.lowest / step_)) {}

    [[nodiscard]] double index(double sample) const {
        return std::nearbyint((sample - origin_) / step_);
    }
    template <class T>
    [[nodiscard]] std::vector<T> values(const std::vector<std::uint16_t>& indices) const {
        std::vector<T> all;
        all.reserve(indices.size());
        for (const std::uint16_t index : indices)
            all.push_back(static_cast<T>(origin_ + step_ * index));
        return all;
    }

  private:
    double step_;
    double origin_;
};

/// Without loss floats are an image of floats.
bool as_floats(const Field& about, double bound) {
    return !about.integer() && bound == 0;
}

class JpegXl final : public Peer {
  public:
    [[nodiscard]] std::string name() const override { return "quantise+JXL"; }
    [[nodiscard]] bool offers(const Field&, const Goal& goal) const override {
        return goal.kind != Goal::Kind::Bytes;
    }

    [[nodiscard]] Result<Bytes> encode(const Field& field, const Goal& goal) const override {
        const double bound = bound_of(goal);
        if (as_floats(field, bound))
            return encode_image({field.cols(), field.rows(), true},
                                std::get_if<std::vector<float>>(&field.values)->data());
        const Quantiser quantiser(field, bound);
        if (quantiser.index(field.highest) > std::numeric_limits<std::uint16_t>::max())
            return Error{ErrorCode::Unsupported, "the indices need more than 16 bits", ""};
        std::vector<std::uint16_t> indices;
        indices.reserve(field.count());
        std::visit(
            [&](const auto& values) {
                for (const auto value : values)
                    indices.push_back(static_cast<std::uint16_t>(quantiser.index(value)));
            },
            field.values);
        return encode_image({field.cols(), field.rows(), false}, indices.data());
    }

    [[nodiscard]] Result<Decoded> decode(const Bytes& bytes, const Field& about,
                                         const Goal& goal) const override {
        const double bound = bound_of(goal);
        if (as_floats(about, bound)) {
            std::vector<float> values(about.count());
            RELIEF_CHECK(decode_image(bytes, {about.cols(), about.rows(), true}, values.data()));
            return Decoded(std::move(values));
        }
        std::vector<std::uint16_t> indices(about.count());
        RELIEF_CHECK(decode_image(bytes, {about.cols(), about.rows(), false}, indices.data()));
        const Quantiser quantiser(about, bound);
        if (about.integer()) return Decoded(quantiser.values<std::int16_t>(indices));
        return Decoded(quantiser.values<float>(indices));
    }
};

}  // namespace

Peers jxl_peers() {
    Peers all;
    all.push_back(std::make_unique<JpegXl>());
    return all;
}

}  // namespace relief::peers
