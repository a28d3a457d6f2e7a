#include <zfp.h>

#include <cmath>

#include "peer.h"

namespace relief::peers {

namespace {

struct FieldFree {
    void operator()(zfp_field* field) const { zfp_field_free(field); }
};
struct StreamClose {
    void operator()(zfp_stream* stream) const { zfp_stream_close(stream); }
};
struct BitsClose {
    void operator()(bitstream* bits) const { stream_close(bits); }
};

/// A zfp stream over bytes and a view of rows x cols samples.
class Coder {
  public:
    Coder(const Field& about, void* samples, zfp_type type, double bound)
        : field_(zfp_field_2d(samples, type, about.cols(), about.rows())),
          stream_(zfp_stream_open(nullptr)) {
        if (bound == 0)
            zfp_stream_set_reversible(stream_.get());
        else
            zfp_stream_set_accuracy(stream_.get(), bound);
    }
    [[nodiscard]] std::size_t largest_size() const {
        return zfp_stream_maximum_size(stream_.get(), field_.get());
    }
    std::size_t compress(Bytes& bytes) {
        open(bytes.data(), bytes.size());
        return zfp_compress(stream_.get(), field_.get());
    }
    std::size_t decompress(const Bytes& bytes) {
        open(const_cast<std::uint8_t*>(bytes.data()), bytes.size());  // it only reads
        return zfp_decompress(stream_.get(), field_.get());
    }

  private:
    void open(void* data, std::size_t size) {
        bits_.reset(stream_open(data, size));
        zfp_stream_set_bit_stream(stream_.get(), bits_.get());
        zfp_stream_rewind(stream_.get());
    }
    std::unique_ptr<zfp_field, FieldFree> field_;
    std::unique_ptr<bitstream, BitsClose> bits_;
    std::unique_ptr<zfp_stream, StreamClose> stream_;
};

/// zfp bounds errors of floats only, and is lossless for 32-bit integers.
bool as_integers(const Field& about, double bound) {
    return about.integer() && bound == 0;
}

/// 0: none. Rounding to integers afterwards adds just under half.
double float_bound(const Field& about, double bound) {
    return about.integer() ? std::floor(bound) + 0.499 : bound;
}

template <class T>
Result<Bytes> compress(const Field& field, zfp_type type, double bound) {
    std::vector<T> samples =
        std::visit([](const auto& values) { return std::vector<T>(values.begin(), values.end()); },
                   field.values);
    Coder coder(field, samples.data(), type, bound);
    Bytes bytes(coder.largest_size());
    bytes.resize(coder.compress(bytes));
    if (bytes.empty()) return refused(ErrorCode::BadInput, "zfp_compress");
    return bytes;
}

template <class T>
Result<std::vector<T>> decompress(const Bytes& bytes, const Field& about, zfp_type type,
                                  double bound) {
    std::vector<T> samples(about.count());
    Coder coder(about, samples.data(), type, bound);
    if (coder.decompress(bytes) == 0) return refused(ErrorCode::BadFile, "zfp_decompress");
    return samples;
}

class Zfp final : public Peer {
  public:
    [[nodiscard]] std::string name() const override { return "zfp"; }
    [[nodiscard]] bool offers(const Field&, const Goal& goal) const override {
        return goal.kind != Goal::Kind::Bytes;
    }

    [[nodiscard]] Result<Bytes> encode(const Field& field, const Goal& goal) const override {
        const double bound = bound_of(goal);
        if (as_integers(field, bound)) return compress<std::int32_t>(field, zfp_type_int32, 0);
        return compress<float>(field, zfp_type_float, float_bound(field, bound));
    }

    [[nodiscard]] Result<Decoded> decode(const Bytes& bytes, const Field& about,
                                         const Goal& goal) const override {
        const double bound = bound_of(goal);
        if (as_integers(about, bound)) {
            RELIEF_TRY(const auto wide, decompress<std::int32_t>(bytes, about, zfp_type_int32, 0));
            return Decoded(std::vector<std::int16_t>(wide.begin(), wide.end()));
        }
        RELIEF_TRY(std::vector<float> samples,
                   decompress<float>(bytes, about, zfp_type_float, float_bound(about, bound)));
        if (about.integer())
            for (float& sample : samples) sample = std::nearbyint(sample);
        return Decoded(std::move(samples));
    }
};

}  // namespace

Peers zfp_peers() {
    Peers all;
    all.push_back(std::make_unique<Zfp>());
    return all;
}

}  // namespace relief::peers
