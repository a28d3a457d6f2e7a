#include "relief/codec/mask_coder.h"

#include <algorithm>
#include <array>
#include <string>

#include "codec/probability.h"
#include "codec/range_coder.h"

namespace relief::codec {

namespace {

/// Rows are kept with kMargin pixels on either side; all pixels outside the image count as valid.
constexpr std::size_t kMargin = 2;
using Row = std::vector<std::uint8_t>;

template <class Coder>
class MaskModel {
  public:
    MaskModel(Coder& coder, std::int64_t cols)
        : coder_(coder),
          row_(static_cast<std::size_t>(cols) + 2 * kMargin, 1),
          above_(row_),
          above2_(row_) {}

    /// Codes a row of 0 and 1; a decoder fills it.
    void code_row(std::uint8_t* pixels) {
        const std::size_t cols = row_.size() - 2 * kMargin;
        const bool same = !Coder::kDecodes && std::equal(pixels, pixels + cols, &above_[kMargin]);
        const bool repeats = code_adaptive(coder_, same, repeats_[last_repeats_]);
        last_repeats_ = repeats;
        if (repeats) {
            std::copy_n(&above_[kMargin], cols, &row_[kMargin]);
        } else {
            code_pixels(pixels, cols);
        }
        if constexpr (Coder::kDecodes) std::copy_n(&row_[kMargin], cols, pixels);
        above2_.swap(above_);
        above_.swap(row_);
    }

  private:
    /// Contexts are WW W, then NWW NW N NE NEE, then NNW NN NNE, the lowest bit the last: each part
    /// shifts by a pixel at a time.
    void code_pixels(const std::uint8_t* pixels, std::size_t cols) {
        const std::uint8_t* const above = &above_[kMargin];
        const std::uint8_t* const above2 = &above2_[kMargin];
        std::size_t west = 3;
        std::size_t north = 8U + 4U + 2U * above[0] + above[1];  // the margin is valid
        std::size_t far_north = 2U + above2[0];
        for (std::size_t c = 0; c < cols; ++c) {
            north = (2 * north & 31) + above[c + 2];
            far_north = (2 * far_north & 7) + above2[c + 1];
            const std::size_t context = (west << 8) + (north << 3) + far_north;
            const bool pixel =
                code_adaptive(coder_, !Coder::kDecodes && pixels[c] != 0, slots_[context]);
            row_[c + kMargin] = pixel;
            west = (2 * west & 3) + pixel;
        }
    }

    Coder& coder_;
    Row row_;
    Row above_;
    Row above2_;
    bool last_repeats_ = true;
    std::array<Slot, 2> repeats_;
    std::array<Slot, 1024> slots_;
};

}  // namespace

std::vector<std::uint8_t> encode_mask(GridView<const std::uint8_t> mask) {
    RangeEncoder encoder;
    MaskModel model(encoder, mask.cols);
    Row pixels(static_cast<std::size_t>(mask.cols));
    for (std::int64_t r = 0; r < mask.rows; ++r) {
        std::transform(mask.row(r), mask.row(r) + mask.cols, pixels.begin(),
                       [](std::uint8_t pixel) { return static_cast<std::uint8_t>(pixel != 0); });
        model.code_row(pixels.data());
    }
    return encoder.finish();
}

Status decode_mask(std::span<const std::uint8_t> bytes, GridView<std::uint8_t> mask) {
    RangeDecoder decoder(bytes);
    MaskModel model(decoder, mask.cols);
    for (std::int64_t r = 0; r < mask.rows && !decoder.ran_out(); ++r) model.code_row(mask.row(r));
    if (!decoder.at_end())
        return Error{ErrorCode::BadFile,
                     "does not end where its image ends; the file is damaged or cut off",
                     "mask of " + std::to_string(bytes.size()) + " bytes"};
    return {};
}

}  // namespace relief::codec
