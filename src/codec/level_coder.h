#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "codec/band_plane.h"
#include "codec/probability.h"

namespace relief::codec {

/// Blocks of kBlock x kBlock coefficients that are all zero cost one flag.
inline constexpr std::int64_t kBlock = 32;

/// Quantises v logarithmically: 0 1 2 .. 7, then four steps an octave, at most `last`.
inline std::uint32_t log_class(std::uint32_t v, std::uint32_t last) {
    if (v < 4) return std::min(v, last);
    const auto octave = static_cast<std::uint32_t>(std::bit_width(v)) - 3;
    return std::min(4 * octave + (v >> octave), last);
}

/// All that a level's coder learns.
struct LevelModel {
    static constexpr std::uint32_t kBands = 8;       ///< later bands share the statistics of the eighth
    static constexpr std::uint32_t kExpected = 64;   ///< classes of the expected magnitude
    static constexpr std::uint32_t kSpatial = 16;
    static constexpr std::uint32_t kOuter = 12;
    static constexpr std::uint32_t kBuckets = 61;    ///< decisions "bucket > u"
    static constexpr std::uint32_t kNear = 16;       ///< buckets with contexts of their own in sets B and C
    static constexpr std::uint32_t kPatterns = 324;

    std::array<Slot, kBands * 4 * 16> block;
    std::array<MixWeights<1>, 1> block_mix;

    std::array<Slot, kBands * kExpected> zero_a;
    std::array<Slot, kSpatial * kOuter * 2> zero_b;
    std::array<Slot, kPatterns * 2> zero_c;
    std::array<MixWeights<3>, kExpected> zero_mix;
    std::array<Refinement, kExpected> zero_refinement;

    std::array<Slot, kExpected * kBuckets * 2> bucket_a;
    std::array<Slot, kSpatial * kOuter * kNear * 2> bucket_b;
    std::array<Slot, kNear * 36 * 2> bucket_c;
    std::array<MixWeights<3>, kBuckets> bucket_mix;
    std::array<Refinement, kBuckets> bucket_refinement;

    std::array<Slot, 81> sign_a;
    std::array<Slot, kBands * 27> sign_b;
    std::array<MixWeights<2>, kBands> sign_mix;
    std::array<Refinement, kBands> sign_refinement;

    std::array<Slot, kBuckets + 1> extra;

    static std::uint32_t floor_of(std::uint32_t c) { return c < 4 ? c : (4 + c % 4) << (c / 4 - 1); }
    static Slot guess(std::uint64_t v, std::uint16_t visits) {
        const std::uint64_t p = ((v * 4 + 4) << 32) / (v * 4 + 4 + 300);
        Slot s; s.slow = static_cast<std::uint32_t>(std::min<std::uint64_t>(p, 0xffffffff)); s.fast = s.slow >> 16; s.visits = visits;
        return s;
    }
    LevelModel() {
        for (std::uint32_t c = 0; c < kExpected; ++c) {
            const Slot s = guess(floor_of(c), 4);
            for (std::uint32_t b = 0; b < kBands; ++b) zero_a[b * kExpected + c] = s;
            for (std::uint32_t b = 0; b < 2 * kBuckets; ++b) bucket_a[b * kExpected + c] = s;
        }
    }
};


/// One decision under one context.
template <class Coder>
bool code_adaptive(Coder& coder, bool bit, Slot& slot) {
    const std::uint32_t one = ((slot.slow >> 16) + slot.fast) / 2;
    bit = coder.code(bit, std::clamp<std::uint32_t>(one, 16, 65520));
    slot.update(bit);
    return bit;
}

/// What is known of a coefficient before it is coded.
struct Surroundings {
    std::uint32_t expected = 0;  ///< class of the expected magnitude
    std::uint32_t mixture = 0;   ///< classes of what neighbours say, and of what parents and siblings say
    std::uint32_t pattern = 0;   ///< nearest neighbours, each 0, 1 or more
    std::uint32_t coarse = 0;    ///< W and N, each in six classes
    std::uint32_t signs_near = 0;
    std::uint32_t signs_across = 0;
};

/// Codes the bands of a level, in order. One text for encoder and decoder: see range_coder.h.
template <class Coder>
class LevelCoder {
  public:
    LevelCoder(Coder& coder, std::span<const BandView> parents) : coder_(coder), model_(new LevelModel) {
        for (const BandView& parent : parents) {
            parents_.emplace_back(parent.predict ? LatticeBox{} : parent.box);
            if (parent.predict) continue;
            for (std::int64_t r = 0; r < parent.box.rows; ++r)
                parents_.back().set_row(parent.box.row0 + r, parent.values.row(r));
        }
    }

    /// `values` are those of the band, or its prediction residuals; a decoder fills them. False: the bytes ran out.
    bool code_band(const LatticeBox& box, GridView<std::int32_t> values, bool predict) {
        band_ = std::min<std::uint32_t>(static_cast<std::uint32_t>(bands_.size()), LevelModel::kBands - 1);
        predict_ = predict;
        bands_.emplace_back(box);
        outer_ = Grid<std::uint32_t>(kBlock, box.cols);
        near_.assign(static_cast<std::size_t>(box.cols), 0);
        const auto blocks = static_cast<std::size_t>((box.cols + kBlock - 1) / kBlock);
        flags_.assign(blocks + 2, 0);
        for (std::int64_t r = 0; r < box.rows; r += kBlock) {
            code_strip(values, r, std::min(kBlock, box.rows - r));
            if constexpr (Coder::kDecodes)
                if (coder_.ran_out()) return false;
        }
        return true;
    }

  private:
    [[nodiscard]] BandPlane& plane() { return bands_.back(); }

    void code_strip(GridView<std::int32_t> values, std::int64_t first, std::int64_t rows) {
        for (std::int64_t r = 0; r < rows; ++r) look_across(plane().box().row0 + first + r, outer_.row(r));
        code_flags(values, first, rows);
        for (std::int64_t r = first; r < first + rows; ++r) code_row(values.row(r), r - first, plane().box().row0 + r);
    }

    void code_flags(GridView<std::int32_t> values, std::int64_t first, std::int64_t rows) {
        const std::int64_t cols = values.cols;
        std::uint8_t* flag = flags_.data() + 1;
        std::uint8_t west_above = 0;
        for (std::int64_t b = 0; b * kBlock < cols; ++b) {
            const std::int64_t c0 = b * kBlock;
            const std::int64_t c1 = std::min(cols, c0 + kBlock);
            bool any = false;
            std::uint64_t activity = 0;
            for (std::int64_t r = 0; r < rows; ++r) {
                if constexpr (!Coder::kDecodes)
                    for (std::int64_t c = c0; c < c1; ++c) any |= values(first + r, c) != 0;
                for (std::int64_t c = c0; c < c1; ++c) activity += outer_(r, c);
            }
            const std::uint32_t known = log_class(static_cast<std::uint32_t>(std::min<std::uint64_t>(activity, 1u<<20)), 63) / 4;
            const std::uint32_t near = flag[b - 1] + 2U * flag[b];
            (void)west_above;
            flag[b] = code_adaptive(coder_, any, model_->block[(band_ * 4 + near) * 16 + known]);
        }
    }

    void look_across(std::int64_t row, std::uint32_t* out) {
        const LatticeBox& box = plane().box();
        std::fill_n(out, box.cols, 0);
        if (predict_) return;
        const std::size_t k = bands_.size() - 1;
        if (k < parents_.size()) add_parent(parents_[k], row, out);
        for (std::size_t s = 0; s < k; ++s) add_sibling(bands_[s], row, out, k);
    }

    void add_parent(const BandPlane& parent, std::int64_t row, std::uint32_t* out) {
        const LatticeBox& box = plane().box();
        const LatticeBox& up = parent.box();
        const std::int64_t begin = std::max(box.col0, 2 * up.col0);
        const std::int64_t end = std::min(box.col0 + box.cols, 2 * (up.col0 + up.cols));
        const std::uint16_t* at = parent.sizes(row >> 1) - up.col0;
        const std::uint16_t* above = parent.sizes((row >> 1) - 1) - up.col0;
        const std::uint16_t* below = parent.sizes((row >> 1) + 1) - up.col0;
        for (std::int64_t j = begin; j < end; ++j) {
            const std::int64_t p = j >> 1;
            out[j - box.col0] += kParent * at[p] + kParentNear * (at[p - 1] + at[p + 1] + above[p] + below[p]);
        }
    }

    void add_sibling(const BandPlane& sibling, std::int64_t row, std::uint32_t* out, std::size_t count) {
        const LatticeBox& box = plane().box();
        const LatticeBox& side = sibling.box();
        const std::int64_t begin = std::max(box.col0, side.col0);
        const std::int64_t end = std::min(box.col0 + box.cols, side.col0 + side.cols);
        const std::uint16_t* at = sibling.sizes(row) - side.col0;
        const std::uint16_t* above = sibling.sizes(row - 1) - side.col0;
        const std::uint16_t* below = sibling.sizes(row + 1) - side.col0;
        const std::uint32_t scale = count == 1 ? 2 : 1;
        for (std::int64_t j = begin; j < end; ++j)
            out[j - box.col0] += scale * (kSibling * at[j] + kSiblingNear * (at[j - 1] + at[j + 1] + above[j] + below[j]));
    }

    void code_row(std::int32_t* values, std::int64_t strip_row, std::int64_t row) {
        const std::int64_t cols = plane().box().cols;
        std::uint16_t* at = plane().sizes(row);
        const std::uint16_t* n = plane().sizes(row - 1);
        const std::uint16_t* nn = plane().sizes(row - 2);
        std::int8_t* sign = plane().signs(row);
        const std::int8_t* sign_n = plane().signs(row - 1);
        const std::int8_t* sign_sibling = sibling_signs(row);
        for (std::int64_t c = 0; c < cols; ++c)
            near_[static_cast<std::size_t>(c)] = kN * n[c] + kNW * n[c - 1] + kNE * n[c + 1] + kNN * nn[c] + kFar * (nn[c - 1] + nn[c + 1] + n[c - 2] + n[c + 2]);
        const std::uint32_t* outer = outer_.row(strip_row);
        for (std::int64_t b = 0; b * kBlock < cols; ++b) {
            const std::int64_t c1 = std::min(cols, (b + 1) * kBlock);
            if (!flags_[static_cast<std::size_t>(b) + 1]) {
                if constexpr (Coder::kDecodes) std::fill(values + b * kBlock, values + c1, 0);
                continue;
            }
            for (std::int64_t c = b * kBlock; c < c1; ++c) {
                const std::uint32_t spatial = near_[static_cast<std::size_t>(c)] + kW * at[c - 1] + kWW * at[c - 2];
                Surroundings s;
                s.expected = log_class(spatial + outer[c], LevelModel::kExpected - 1);
                s.mixture = (log_class(spatial, 4 * LevelModel::kSpatial - 1) / 4) * LevelModel::kOuter +
                            log_class(outer[c], 4 * LevelModel::kOuter - 1) / 4;
                s.pattern = pattern(at[c - 1], n[c], n[c - 1], n[c + 1]) * 4 + std::min(3u,log_class(outer[c],63)/4);
                s.coarse = small(at[c - 1]) * 6 + small(n[c]);
                s.signs_near = static_cast<std::uint32_t>(sign[c - 1] + 1 + 3 * (sign_n[c] + 1));
                s.signs_across = sign_sibling ? static_cast<std::uint32_t>(sign_sibling[c] + 1) : 1U;
                const std::int32_t q = code_value(values[c], s);
                if constexpr (Coder::kDecodes) values[c] = q;
                set(at[c], sign[c], q);
            }
        }
    }

    static void set(std::uint16_t& size, std::int8_t& sign, std::int32_t q) {
        const std::uint32_t m = q < 0 ? 0U - static_cast<std::uint32_t>(q) : static_cast<std::uint32_t>(q);
        size = static_cast<std::uint16_t>(std::min<std::uint32_t>(m, 65535));
        sign = static_cast<std::int8_t>((q > 0) - (q < 0));
    }

    const std::int8_t* sibling_signs(std::int64_t) const { return nullptr; }

    static std::uint32_t small(std::uint32_t m) { return m < 3 ? m : m < 5 ? 3U : m < 9 ? 4U : 5U; }
    static std::uint32_t pattern(std::uint32_t w, std::uint32_t n, std::uint32_t nw, std::uint32_t ne) {
        return ((std::min(w, 2U) * 3 + std::min(n, 2U)) * 3 + std::min(nw, 2U)) * 3 + std::min(ne, 2U);
    }

    std::int32_t code_value(std::int32_t q, const Surroundings& s) {
        LevelModel& m = *model_;
        const std::uint32_t kind = predict_;
        if (!code_mixed<3>(coder_, q != 0,
                           {&m.zero_a[band_ * LevelModel::kExpected + s.expected],
                            &m.zero_b[kind * LevelModel::kSpatial * LevelModel::kOuter + s.mixture],
                            &m.zero_c[kind * LevelModel::kPatterns + s.pattern]},
                           m.zero_mix[band_], m.zero_refinement[s.expected]))
            return 0;
        const bool negative = code_mixed<2>(coder_, q < 0,
                                            {&m.sign_a[s.signs_near + 9 * s.signs_across],
                                             &m.sign_b[band_ * 27 + s.signs_near + 9 * s.signs_across]},
                                            m.sign_mix[band_], m.sign_refinement[band_]);
        const std::uint32_t magnitude = q < 0 ? 0U - static_cast<std::uint32_t>(q) : static_cast<std::uint32_t>(q);
        const std::uint32_t decoded = 1 + code_excess(magnitude - 1, s);
        return static_cast<std::int32_t>(negative ? 0U - decoded : decoded);
    }

    /// A magnitude less one: its bucket in unary, then its place in the bucket.
    std::uint32_t code_excess(std::uint32_t excess, const Surroundings& s) {
        const std::uint32_t bucket = bucket_of(excess);
        std::uint32_t u = 0;
        while (u < LevelModel::kBuckets && code_bucket(bucket > u, u, s)) ++u;
        if (u < 4) return u;
        const int bits = static_cast<int>(u / 2) - 1;
        const std::uint32_t base = (2 + (u & 1)) << bits;
        const std::uint32_t offset = excess - base;
        const bool top = code_adaptive(coder_, (offset >> (bits - 1) & 1) != 0, model_->extra[u]);
        std::uint32_t place = static_cast<std::uint32_t>(top) << (bits - 1);
        if (bits > 1) place |= coder_.code_raw(offset & ((1U << (bits - 1)) - 1), bits - 1);
        return base + place;
    }

    bool code_bucket(bool more, std::uint32_t u, const Surroundings& s) {
        LevelModel& m = *model_;
        const std::uint32_t kind = predict_;
        const std::uint32_t near = std::min(u, LevelModel::kNear - 1);
        return code_mixed<3>(
            coder_, more,
            {&m.bucket_a[(kind * LevelModel::kBuckets + u) * LevelModel::kExpected + s.expected],
             &m.bucket_b[(kind * LevelModel::kNear + near) * LevelModel::kSpatial * LevelModel::kOuter + s.mixture],
             &m.bucket_c[(kind * LevelModel::kNear + near) * 36 + s.coarse]},
            m.bucket_mix[0], m.bucket_refinement[u]);
    }

    /// Excesses 0 1 2 3, then two buckets an octave: [4, 5] [6, 7] [8, 11] [12, 15] ..
    static std::uint32_t bucket_of(std::uint32_t excess) {
        if (excess < 4) return excess;
        const auto octave = static_cast<std::uint32_t>(std::bit_width(excess)) - 1;
        return 2 * octave + (excess >> (octave - 1) & 1);
    }

    static constexpr std::uint32_t kW = 10, kN = 10, kNW = 5, kNE = 5, kWW = 3, kNN = 3, kFar = 0;
    static constexpr std::uint32_t kParent = 2, kParentNear = 1;
    static constexpr std::uint32_t kSibling = 2, kSiblingNear = 1;

    Coder& coder_;
    std::unique_ptr<LevelModel> model_;
    std::vector<BandPlane> parents_;
    std::vector<BandPlane> bands_;
    std::uint32_t band_ = 0;
    bool predict_ = false;
    Grid<std::uint32_t> outer_;
    std::vector<std::uint32_t> near_;
    std::vector<std::uint8_t> flags_;
};

}  // namespace relief::codec
