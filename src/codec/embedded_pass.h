#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "codec/embedded_band.h"
#include "codec/embedded_model.h"
#include "codec/log_class.h"
#include "codec/range_coder.h"

namespace relief::codec {

/// An encoder that turns a 1 into a 0 when it costs more than it is worth.
template <class Coder>
class Thrifty : public Coder {
  public:
    /// What the next decision, with the sign that follows a 1, may cost in bits.
    void set_worth(double bits) { worth_ = bits; }

    bool code(bool bit, std::uint32_t one) {
        if (bit && worth_ < 1 - kOdds.stretch[one >> 4] / kOddsPerBit) bit = false;
        worth_ = kPriceless;
        return Coder::code(bit, one);
    }

  private:
    static constexpr double kOddsPerBit = 177.4456782334599;  // 256 ln 2
    static constexpr double kPriceless = std::numeric_limits<double>::infinity();

    double worth_ = kPriceless;
};

/// Codes the passes of a stream. One text for encoder and decoder: see range_coder.h. Encoders are
/// Thrifty.
template <class Coder, int kSets>
class PassCoder {
  public:
    /// bits_per_worth: what a unit of StreamBand::worth may cost.
    PassCoder(Coder& coder, std::vector<EmbeddedBand>& bands, double bits_per_worth)
        : coder_(coder),
          bands_(bands),
          bits_per_worth_(bits_per_worth),
          model_(new EmbeddedModel<kSets>) {}

    void code_pass(int plane, int pass) {
        plane_ = plane;
        plane_class_ = std::min(static_cast<std::uint32_t>(plane), Contexts::kPlanes - 1);
        pass_ = pass;
        for (EmbeddedBand& band : bands_) {
            if (plane >= band.planes) continue;
            band_ = &band;
            const int kind = std::min<int>(band.source.channel, Contexts::kKinds - 1);
            kind_ = static_cast<std::uint32_t>(kind);
            if (pass == 1) band.begin_plane(plane);
            for (row_ = band.row0; row_ < band.row0 + band.source.box.rows; ++row_) code_row();
        }
    }

  private:
    using Contexts = EmbeddedContexts;
    using Context = std::uint32_t;

    static constexpr std::size_t kBlock = 64;
    /// Columns of which nothing is expected are coded so many at a time.
    static constexpr std::size_t kGroup = 16;
    static constexpr int kGroupBits = 4;

    /// Weights of known magnitudes, which come in eighths, in the expected one.
    static constexpr int kCross = 18, kDiagonal = 9, kFar = 6, kKnight = 3;
    static constexpr int kSibling = 5, kParent = 7, kParentCross = 2;
    static constexpr int kExpectedOne = 8 * 20;
    static constexpr int kNearCross = 2;
    static_assert(255 * (4 * (kCross + kDiagonal + kFar) + 8 * (kKnight + kSibling) + kParent +
                         4 * kParentCross) <
                  65536);

    void code_row() {
        EmbeddedBand& b = *band_;
        const std::int64_t r = row_ - b.row0;
        values_ = b.source.values.row(r);
        worth_ = b.source.worth.count() != 0 ? b.source.worth.row(r) : nullptr;
        for (std::int64_t w = 0; w < b.words(); ++w) {
            const std::uint64_t significant = b.significant(row_, w);
            std::uint64_t todo = pass_ == 2 ? significant : b.columns(w) & ~significant;
            if (pass_ > 1) todo &= ~b.visited(row_, w);
            if (todo == 0) continue;
            first_ = 64 * w;
            look_across();
            look_around();
            if (pass_ == 1)
                b.visited(row_, w) = find_likely(todo);
            else if (pass_ == 2)
                refine(todo);
            else
                find(todo);
        }
    }

    /// Pass 1 of a block: codes which of the columns `todo` become significant, where an expected
    /// magnitude of at least 1/2 asks for it. Returns the columns coded.
    std::uint64_t find_likely(std::uint64_t todo) {
        std::uint64_t visited = 0;
        for (; todo != 0; todo &= todo - 1) {
            const auto k = static_cast<std::size_t>(std::countr_zero(todo));
            if (expected_[k] < kExpectedOne / 2) continue;
            visited |= std::uint64_t{1} << k;
            if (code_found(k)) begin_value(k);
        }
        return visited;
    }

    /// Pass 3 of a block: the same for all columns `todo`.
    void find(std::uint64_t todo) {
        while (todo != 0) {
            auto k = static_cast<std::size_t>(std::countr_zero(todo));
            bool found = false;
            if (is_quiet(todo, k)) {
                const std::size_t gap = code_gap(k);
                found = gap < kGroup;
                k += gap;
                todo &= found ? ~std::uint64_t{1} << k : ~lowest_group() << (k - kGroup);
            } else {
                found = code_found(k);
                todo &= todo - 1;
            }
            if (found) begin_value(k);
        }
    }

    static constexpr std::uint64_t lowest_group() { return (std::uint64_t{1} << kGroup) - 1; }

    /// Nothing is expected of the group of columns that starts at k, and all are to be coded.
    [[nodiscard]] bool is_quiet(std::uint64_t todo, std::size_t k) const {
        if (k % kGroup != 0 || (~todo >> k & lowest_group()) != 0) return false;
        std::uint32_t any = 0;
        for (std::size_t i = k; i < k + kGroup; ++i) any |= expected_[i];
        return any == 0;
    }

    /// How many columns from k on stay 0 before one of the group does not.
    std::size_t code_gap(std::size_t k) {
        std::size_t gap = kGroup;
        if constexpr (!Coder::kDecodes) gap = find_gap(k);
        const Context context = Contexts::kGap + kind_ * Contexts::kPlanes + plane_class_;
        Chance& chance = model_->chances[context];
        const bool any = coder_.code(gap < kGroup, codable(chance.one >> 16));
        chance.update(any);
        if (any) return coder_.code_raw(static_cast<std::uint32_t>(gap), kGroupBits);
        if constexpr (!Coder::kDecodes)
            if (gap < kGroup) value(k + gap) = 0;
        return kGroup;
    }

    /// The gap in what is to be encoded. A value that is alone in its group may be dropped.
    std::size_t find_gap(std::size_t k) {
        std::size_t gap = kGroup;
        std::size_t values = 0;
        for (std::size_t i = kGroup; i-- > 0;) {
            if (magnitude_of(value(k + i)) >> plane_ == 0) continue;
            gap = i;
            ++values;
        }
        if (values == 1) offer(k + gap, kGroupBits);
        return gap;
    }

    /// Lets the encoder drop the value of column k if it is not worth its bits, and `more` bits.
    void offer(std::size_t k, double more) {
        if (plane_ == 0 && worth_) coder_.set_worth(bits_per_worth_ * worth_[index(k)] - more);
    }

    /// Pass 2 of a block.
    void refine(std::uint64_t todo) {
        for (; todo != 0; todo &= todo - 1) {
            const auto k = static_cast<std::size_t>(std::countr_zero(todo));
            std::int32_t& v = value(k);
            const std::uint32_t known = magnitude_of(v) >> plane_;
            const bool bit = code_bit((known & 1) != 0, known / 2, k);
            if constexpr (Coder::kDecodes) v += (v < 0 ? -bit : bit) * (1 << plane_);
            learn(k, known_magnitude((known & ~1U) + bit));
        }
    }

    /// The column of the frame, and that of the band's values.
    [[nodiscard]] std::int64_t column(std::size_t k) const {
        return first_ + static_cast<std::int64_t>(k);
    }
    [[nodiscard]] std::int64_t index(std::size_t k) const { return column(k) - band_->col0; }
    std::int32_t& value(std::size_t k) { return values_[index(k)]; }

    void begin_value(std::size_t k) {
        std::int32_t& v = value(k);
        const bool negative = code_sign(v < 0, k);
        if constexpr (Coder::kDecodes) v = (negative ? -1 : 1) * (1 << plane_);
        band_->sign.row(row_)[column(k)] = negative ? -1 : 1;
        band_->significant(row_, first_ / 64) |= std::uint64_t{1} << k;
        learn(k, known_magnitude(1));
    }

    /// Sums of the columns to come count what is known of column k from now on.
    void learn(std::size_t k, std::uint8_t known) {
        std::uint8_t& at = band_->known.row(row_)[column(k)];
        const int more = known - at;
        at = known;
        add(near_[k + 1], kNearCross * more);
        add(expected_[k + 1], kCross * more);
        add(expected_[k + 2], kFar * more);
    }

    static void add(std::uint16_t& sum, int more) { sum = static_cast<std::uint16_t>(sum + more); }

    /// Sums over the neighbours of each column of a block, and over all that tells about it.
    void look_around() {
        const RimmedGrid<std::uint8_t>& known = band_->known;
        const std::uint8_t* nn = known.row(row_ - 2) + first_;
        const std::uint8_t* n = known.row(row_ - 1) + first_;
        const std::uint8_t* at = known.row(row_) + first_;
        const std::uint8_t* s = known.row(row_ + 1) + first_;
        const std::uint8_t* ss = known.row(row_ + 2) + first_;
        for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(kBlock); ++k) {
            const int cross = n[k] + s[k] + at[k - 1] + at[k + 1];
            const int diagonal = n[k - 1] + n[k + 1] + s[k - 1] + s[k + 1];
            const int far = nn[k] + ss[k] + at[k - 2] + at[k + 2];
            const int knight = nn[k - 1] + nn[k + 1] + n[k - 2] + n[k + 2] + s[k - 2] + s[k + 2] +
                               ss[k - 1] + ss[k + 1];
            near_[k] = static_cast<std::uint16_t>(kNearCross * cross + diagonal);
            expected_[k] = static_cast<std::uint16_t>(kCross * cross + kDiagonal * diagonal +
                                                      kFar * far + kKnight * knight +
                                                      kSibling * siblings_[k] + parents_[k]);
        }
    }

    void look_across() {
        const std::uint8_t* n = band_->above.row(row_ / 2 - 1) + first_ / 2;
        const std::uint8_t* at = band_->above.row(row_ / 2) + first_ / 2;
        const std::uint8_t* s = band_->above.row(row_ / 2 + 1) + first_ / 2;
        for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(kBlock / 2); ++k) {
            const int sum = kParent * at[k] + kParentCross * (n[k] + s[k] + at[k - 1] + at[k + 1]);
            parents_[2 * k] = parents_[2 * k + 1] = static_cast<std::uint16_t>(sum);
        }
        siblings_.fill(0);
        for (const EmbeddedBand::Tap& tap : band_->siblings) {
            const std::uint8_t* other = tap.band->known.row(row_ + tap.row) + first_ + tap.col;
            for (std::size_t k = 0; k < kBlock; ++k) add(siblings_[k], tap.weight * other[k]);
        }
    }

    /// Classes of sums: four, two and one an octave from 1 on.
    static Context expected_class(std::uint32_t sum) {
        return log_class(sum >> 4, Contexts::kExpected - 1);
    }
    static Context near_class(std::uint32_t sum) {
        return log_class(sum >> 2, 2 * Contexts::kNear - 1) / 2;
    }
    static Context siblings_class(std::uint32_t sum) {
        return log_class(sum >> 2, 4 * Contexts::kSiblings - 1) / 4;
    }
    static Context size_class(std::uint32_t sum) {
        return log_class(sum >> 1, 4 * Contexts::kSizes - 1) / 4;
    }
    static Context prefix_class(std::uint32_t prefix) {
        if (prefix < 8) return prefix - 1;
        return std::min(static_cast<Context>(std::bit_width(prefix)) + 3, Contexts::kPrefixes - 1);
    }
    static Context sign_class(int sign) { return static_cast<Context>(sign + 1); }

    /// Whether the value of column k becomes significant. An encoder may drop it instead.
    bool code_found(std::size_t k) {
        bool bit = false;
        if constexpr (!Coder::kDecodes) {
            bit = magnitude_of(value(k)) >> plane_ != 0;
            if (bit) offer(k, 0);
        }
        const Context expected = expected_class(expected_[k]);
        const bool coded =
            code(bit,
                 {Contexts::kFoundExpected +
                      (kind_ * Contexts::kPlanes + plane_class_) * Contexts::kExpected + expected,
                  Contexts::kFoundNear + kind_ * Contexts::kNear + near_class(near_[k]),
                  Contexts::kFoundSiblings +
                      (kind_ * Contexts::kSiblings + siblings_class(siblings_[k])) *
                          Contexts::kExpected +
                      expected},
                 model_->found, expected);
        if constexpr (!Coder::kDecodes)
            if (bit && !coded) value(k) = 0;
        return coded;
    }

    bool code_sign(bool negative, std::size_t k) {
        const std::int64_t c = column(k);
        const std::int8_t* at = band_->sign.row(row_) + c;
        const std::uint8_t* known = band_->known.row(row_) + c;
        const auto sibling = [&](const EmbeddedBand* other) {
            return sign_class(other ? other->sign.row(row_)[c] : 0);
        };
        const Context w = sign_class(at[-1]);
        const Context e = sign_class(at[1]);
        const Context n = sign_class(band_->sign.row(row_ - 1)[c]);
        const Context s = sign_class(band_->sign.row(row_ + 1)[c]);
        const Context near = sibling(band_->signed_siblings[0]);
        const Context next = sibling(band_->signed_siblings[1]);
        const auto size = size_class(static_cast<std::uint32_t>(known[-1] + known[1]));
        return code(negative,
                    {Contexts::kSignSiblings + kind_ * Contexts::kSigns +
                         ((w * 3 + n) * 3 + near) * 3 + next,
                     Contexts::kSignRing + kind_ * Contexts::kSigns + ((w * 3 + e) * 3 + n) * 3 + s,
                     Contexts::kSignPair + ((kind_ * 3 + w) * 3 + e) * Contexts::kSizes + size},
                    model_->sign, 0);
    }

    /// The next bit of a value whose known bits are `prefix`.
    bool code_bit(bool bit, std::uint32_t prefix, std::size_t k) {
        const Context size = prefix_class(prefix);
        return code(
            bit,
            {Contexts::kBitPlane +
                 (kind_ * Contexts::kPlanes + plane_class_) * Contexts::kPrefixes + size,
             Contexts::kBitPrefix + kind_ * Contexts::kPrefixes + size,
             Contexts::kBitNear +
                 (kind_ * Contexts::kNear + near_class(near_[k])) * Contexts::kPrefixes + size},
            model_->bit, size);
    }

    template <std::uint32_t kClasses>
    bool code(bool bit, const std::array<Context, 3>& contexts,
              EmbeddedWeights<kSets, kClasses>& weights, Context weight_class) {
        std::array<Chance*, kSets> chances;
        for (std::size_t k = 0; k < kSets; ++k) chances[k] = &model_->chances[contexts[k]];
        return code_blended<kSets>(coder_, bit, chances, weights.by_kind[kind_],
                                   weights.by_class[weight_class]);
    }

    Coder& coder_;
    std::vector<EmbeddedBand>& bands_;
    double bits_per_worth_;
    std::unique_ptr<EmbeddedModel<kSets>> model_;

    int plane_ = 0;
    Context plane_class_ = 0;
    int pass_ = 1;
    EmbeddedBand* band_ = nullptr;
    Context kind_ = 0;
    std::int64_t row_ = 0;  ///< of the frame
    std::int32_t* values_ = nullptr;
    const std::uint8_t* worth_ = nullptr;
    std::int64_t first_ = 0;  ///< column of the frame where the block starts

    /// Of the columns of the block: 2 (W + E + N + S) + diagonals; what is to be expected; siblings
    /// and parents in it. Two columns more for what the last ones add behind them.
    std::array<std::uint16_t, kBlock + 2> near_{};
    std::array<std::uint16_t, kBlock + 2> expected_{};
    std::array<std::uint16_t, kBlock> siblings_{};
    std::array<std::uint16_t, kBlock> parents_{};
};

}  // namespace relief::codec
