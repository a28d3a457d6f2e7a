#pragma once

#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "codec/embedded_band.h"
#include "codec/embedded_model.h"
#include "codec/range_coder.h"

namespace relief::codec {

/// An encoder that turns a 1 into a 0 when it costs more than it is worth.
template <class Coder>
class Thrifty : public Coder {
  public:
    /// Of the next decision only.
    void set_worth(double bits) { worth_ = bits; }

    bool code(bool bit, std::uint32_t one) {
        // A sign comes with every 1.
        if (bit && worth_ < 1 - kOdds.stretch[one >> 4] / kOddsPerBit) bit = false;
        worth_ = kPriceless;
        return Coder::code(bit, one);
    }

  private:
    static constexpr double kOddsPerBit = 177.4456782334599;  // 256 ln 2
    static constexpr double kPriceless = std::numeric_limits<double>::infinity();
    double worth_ = kPriceless;
};

/// Codes the passes of a stream. One text for encoder and decoder: see range_coder.h.
template <class Coder, int kSets>
class StreamCoder {
  public:
    StreamCoder(Coder& coder, std::vector<EmbeddedBand>& bands, double bits_per_squared_error)
        : coder_(coder),
          bands_(bands),
          model_(new EmbeddedModel),
          price_(bits_per_squared_error / 64) {}

    void code_pass(int plane, int pass) {
        plane_ = plane;
        for (EmbeddedBand& band : bands_) {
            if (plane >= band.planes) continue;
            band_ = &band;
            kind_ = band.kind;
            if (pass == 1) band.begin_plane(plane);
            for (std::int64_t r = 0; r < band.source.box.rows; ++r) code_row(r, pass);
        }
    }

  private:
    static constexpr std::uint16_t kLikely = 80;  // an expected magnitude of 1/2

    void code_row(std::int64_t r, int pass) {
        EmbeddedBand& b = *band_;
        const std::int64_t row = b.row0 + r;
        values_ = b.source.values.row(r) - b.col0;
        worth_ = b.source.worth.data ? b.source.worth.row(r) - b.col0 : nullptr;
        for (std::int64_t w = 0; w < b.words(); ++w) {
            const std::uint64_t significant = b.significant.row(row)[w];
            const std::uint64_t todo = pass == 1 ? b.columns(w) & ~significant
                                       : pass == 2
                                           ? significant & ~b.visited.row(row)[w]
                                           : b.columns(w) & ~significant & ~b.visited.row(row)[w];
            if (todo == 0) continue;
            look_around(row, w);
            if (pass == 2)
                refine(row, w, todo);
            else
                search(row, w, todo, pass == 1 ? kLikely : 0);
        }
    }

    void search(std::int64_t row, std::int64_t w, std::uint64_t todo, std::uint16_t least) {
        EmbeddedBand& b = *band_;
        std::uint64_t coded = 0;
        std::uint64_t found = 0;
        for (; todo != 0; todo &= todo - 1) {
            const auto k = static_cast<std::size_t>(std::countr_zero(todo));
            if (expected_[k] < least) continue;
            const std::uint64_t bit = todo & (~todo + 1);
            coded |= bit;
            const std::int64_t c = 64 * w + static_cast<std::int64_t>(k);
            if (!code_significance(c, k)) continue;
            found |= bit;
            const bool negative = code_sign(row, c);
            if constexpr (Coder::kDecodes) values_[c] = (negative ? -1 : 1) * (1 << plane_);
            b.sign.row(row)[c] = negative ? -1 : 1;
            learn(row, c, k, known_magnitude(1));
        }
        b.visited.row(row)[w] |= coded;
        b.significant.row(row)[w] |= found;
    }

    void refine(std::int64_t row, std::int64_t w, std::uint64_t todo) {
        band_->visited.row(row)[w] |= todo;
        for (; todo != 0; todo &= todo - 1) {
            const auto k = static_cast<std::size_t>(std::countr_zero(todo));
            const std::int64_t c = 64 * w + static_cast<std::int64_t>(k);
            const std::uint32_t magnitude = magnitude_of(values_[c]);
            const std::uint32_t prefix = magnitude >> (plane_ + 1);
            const bool bit = code_bit((magnitude >> plane_ & 1) != 0, prefix, k);
            if constexpr (Coder::kDecodes)
                values_[c] += bit ? (values_[c] < 0 ? -1 : 1) * (1 << plane_) : 0;
            learn(row, c, k, known_magnitude(2 * prefix + bit));
        }
    }

    void learn(std::int64_t row, std::int64_t c, std::size_t k, std::uint8_t known) {
        std::uint8_t& at = band_->known.row(row)[c];
        const auto gain = static_cast<std::uint16_t>(known - at);
        at = known;
        near_[k + 1] = static_cast<std::uint16_t>(near_[k + 1] + 2 * gain);
        expected_[k + 1] = static_cast<std::uint16_t>(expected_[k + 1] + 18 * gain);
        expected_[k + 2] = static_cast<std::uint16_t>(expected_[k + 2] + 6 * gain);
    }

    void look_around(std::int64_t row, std::int64_t w) {
        look_across(row, w);
        const EmbeddedBand& b = *band_;
        const std::uint8_t* at = b.known.row(row) + 64 * w;
        const std::uint8_t* n = b.known.row(row - 1) + 64 * w;
        const std::uint8_t* s = b.known.row(row + 1) + 64 * w;
        const std::uint8_t* nn = b.known.row(row - 2) + 64 * w;
        const std::uint8_t* ss = b.known.row(row + 2) + 64 * w;
        for (std::ptrdiff_t k = 0; k < 64; ++k) {
            const int cross = at[k - 1] + at[k + 1] + n[k] + s[k];
            const int diagonal = n[k - 1] + n[k + 1] + s[k - 1] + s[k + 1];
            const int far = at[k - 2] + at[k + 2] + nn[k] + ss[k];
            const int knights = n[k - 2] + n[k + 2] + s[k - 2] + s[k + 2] + nn[k - 1] + nn[k + 1] +
                                ss[k - 1] + ss[k + 1];
            near_[k] = static_cast<std::uint16_t>(2 * cross + diagonal);
            expected_[k] = static_cast<std::uint16_t>(18 * cross + 9 * diagonal + 6 * far +
                                                      3 * knights + across_[k]);
        }
    }

    void look_across(std::int64_t row, std::int64_t w) {
        const EmbeddedBand& b = *band_;
        const std::uint8_t* p = b.parent.row(row >> 1) + 32 * w;
        const std::uint8_t* pn = b.parent.row((row >> 1) - 1) + 32 * w;
        const std::uint8_t* ps = b.parent.row((row >> 1) + 1) + 32 * w;
        for (std::ptrdiff_t k = 0; k < 32; ++k) {
            const auto sum =
                static_cast<std::uint16_t>(7 * p[k] + 2 * (p[k - 1] + p[k + 1] + pn[k] + ps[k]));
            across_[2 * k] = sum;
            across_[2 * k + 1] = sum;
        }
        sibling_.fill(0);
        switch (b.kind) {
            case 1:
                add_sibling(b.siblings[1], row, 64 * w, 2);
                break;
            case 2:
                add_sibling(b.siblings[0], row, 64 * w, 2);
                add_sibling(b.siblings[0], row, 64 * w - 1, 1);
                add_sibling(b.siblings[0], row + 1, 64 * w, 1);
                break;
            case 3:
                add_sibling(b.siblings[1], row, 64 * w, 2);
                add_sibling(b.siblings[1], row, 64 * w + 1, 1);
                add_sibling(b.siblings[0], row, 64 * w, 2);
                add_sibling(b.siblings[0], row + 1, 64 * w, 1);
                break;
        }
        for (std::size_t k = 0; k < 64; ++k)
            across_[k] = static_cast<std::uint16_t>(across_[k] + 5 * sibling_[k]);
    }

    void add_sibling(const EmbeddedBand* s, std::int64_t row, std::int64_t c, int weight) {
        if (!s) return;
        const std::uint8_t* at = s->known.row(row) + c;
        for (std::size_t k = 0; k < 64; ++k)
            sibling_[k] = static_cast<std::uint16_t>(sibling_[k] + weight * at[k]);
    }

    template <std::size_t nA, std::size_t nB>
    bool mixed(bool bit, const std::array<Slot*, 3>& slots, MixWeights<3>& a, MixWeights<3>& b,
               Refinement& refinement) {
        return code_mixed2<3>(coder_, bit, slots, a, b, refinement);
    }

    bool code_significance(std::int64_t c, std::size_t k) {
        EmbeddedModel& m = *model_;
        const std::uint32_t near = log_class(near_[k] >> 2, 2 * EmbeddedModel::kNear - 1) / 2;
        const std::uint32_t expected = log_class(expected_[k] >> 3, EmbeddedModel::kExpected - 1);
        const std::uint32_t sibling =
            log_class(sibling_[k] >> 2, 4 * EmbeddedModel::kSiblings - 1) / 4;
        const std::uint32_t p = std::min<std::uint32_t>(plane_, EmbeddedModel::kPlanes - 1);
        const bool bit = magnitude_of(values_[c]) >> plane_ != 0;
        if constexpr (requires { coder_.set_worth(1.0); })
            if (bit && plane_ == 0 && worth_) coder_.set_worth(worth_[c] * price_);
        const bool coded =
            code_mixed2<3>(coder_, bit,
                           {&m.significant_near[kind_ * EmbeddedModel::kNear + near],
                            &m.significant_expected[(kind_ * EmbeddedModel::kPlanes + p) *
                                                        EmbeddedModel::kExpected +
                                                    expected],
                            &m.significant_siblings[(kind_ * EmbeddedModel::kSiblings + sibling) *
                                                        EmbeddedModel::kExpected +
                                                    expected]},
                           m.significant_mix[kind_], m.significant_mix_expected[expected],
                           m.significant_refinement[kind_ * EmbeddedModel::kExpected + expected]);
        if (bit && !coded) values_[c] = 0;
        return coded;
    }

    static std::uint32_t sign_class(int sign) { return static_cast<std::uint32_t>(sign + 1); }

    bool code_sign(std::int64_t row, std::int64_t c) {
        EmbeddedModel& m = *model_;
        const EmbeddedBand& b = *band_;
        const std::int8_t* at = b.sign.row(row) + c;
        const std::uint32_t w = sign_class(at[-1]), e = sign_class(at[1]);
        const std::uint32_t n = sign_class(b.sign.row(row - 1)[c]),
                            s = sign_class(b.sign.row(row + 1)[c]);
        const std::uint32_t z1 =
            sign_class(b.kind > 1 && b.siblings[0] ? b.siblings[0]->sign.row(row)[c] : 0);
        const std::uint32_t z2 =
            sign_class(b.kind == 3 && b.siblings[1]   ? b.siblings[1]->sign.row(row)[c]
                       : b.kind == 2 && b.siblings[0] ? b.siblings[0]->sign.row(row + 1)[c]
                                                      : 0);
        const std::uint8_t* known = b.known.row(row) + c;
        const std::uint32_t pair = log_class(static_cast<std::uint32_t>(known[-1] + known[1]) >> 1,
                                             4 * EmbeddedModel::kPairs - 1) /
                                   4;
        return code_mixed2<3>(
            coder_, values_[c] < 0,
            {&m.sign_ring[kind_ * 81 + ((w * 3 + e) * 3 + n) * 3 + s],
             &m.sign_siblings[kind_ * 81 + ((w * 3 + n) * 3 + z1) * 3 + z2],
             &m.sign_pair[(kind_ * 9 + w * 3 + e) * EmbeddedModel::kPairs + pair]},
            m.sign_mix[kind_], m.sign_mix2[0], m.sign_refinement[kind_]);
    }

    bool code_bit(bool bit, std::uint32_t prefix, std::size_t k) {
        EmbeddedModel& m = *model_;
        const std::uint32_t size = prefix < 8    ? prefix - 1
                                   : prefix < 16 ? 7
                                   : prefix < 32 ? 8
                                   : prefix < 64 ? 9
                                                 : 10;
        const std::uint32_t near = log_class(near_[k] >> 2, 2 * EmbeddedModel::kNear - 1) / 2;
        const std::uint32_t p = std::min<std::uint32_t>(plane_, EmbeddedModel::kPlanes - 1);
        return code_mixed2<3>(
            coder_, bit,
            {&m.bit_prefix[kind_ * EmbeddedModel::kPrefixes + size],
             &m.bit_plane[(kind_ * EmbeddedModel::kPlanes + p) * EmbeddedModel::kPrefixes + size],
             &m.bit_near[(kind_ * EmbeddedModel::kNear + near) * EmbeddedModel::kPrefixes + size]},
            m.bit_mix[kind_], m.bit_mix2[size],
            m.bit_refinement[kind_ * EmbeddedModel::kPrefixes + size]);
    }

    Coder& coder_;
    std::vector<EmbeddedBand>& bands_;
    std::unique_ptr<EmbeddedModel> model_;
    double price_;  ///< bits for a unit of worth
    EmbeddedBand* band_ = nullptr;
    std::uint32_t kind_ = 0;
    int plane_ = 0;
    std::int32_t* values_ = nullptr;
    const std::uint8_t* worth_ = nullptr;
    std::array<std::uint16_t, 66> near_{};
    std::array<std::uint16_t, 66> expected_{};
    std::array<std::uint16_t, 64> across_{};
    std::array<std::uint16_t, 64> sibling_{};
};

}  // namespace relief::codec
