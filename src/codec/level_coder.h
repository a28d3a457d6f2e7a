#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "codec/band_plane.h"
#include "codec/level_model.h"
#include "codec/range_coder.h"
#include "relief/codec/band_coder.h"

namespace relief::codec {

/// Codes the bands of a level, in order. One text for encoder and decoder: see range_coder.h.
template <class Coder>
class LevelCoder {
  public:
    LevelCoder(Coder& coder, std::span<const BandView> parents)
        : coder_(coder), model_(new LevelModel) {
        for (const BandView& parent : parents) {
            parents_.emplace_back(parent.predict ? LatticeBox{} : parent.box);
            if (!parent.predict) parents_.back().set_all(parent.values);
        }
    }

    /// `values` are those of the band, or what a prediction leaves of them; a decoder fills them.
    /// False: the bytes ran out.
    bool code_band(const LatticeBox& box, GridView<std::int32_t> values, bool predicted) {
        const std::size_t index = planes_.size();
        band_ = static_cast<std::uint32_t>(std::min<std::size_t>(index, LevelModel::kBands - 1));
        kind_ = predicted;
        planes_.emplace_back(box);
        parent_ = index < parents_.size() ? &parents_[index] : nullptr;
        across_ = Grid<std::uint32_t>(kBlock, box.cols);
        above_.assign(static_cast<std::size_t>(box.cols), 0);
        flags_.assign(static_cast<std::size_t>((box.cols + kBlock - 1) / kBlock + 1), 0);
        for (std::int64_t r = 0; r < box.rows; r += kBlock) {
            code_strip(values, r, std::min(kBlock, box.rows - r));
            if constexpr (Coder::kDecodes)
                if (coder_.ran_out()) return false;
        }
        return true;
    }

  private:
    /// A block of kBlock x kBlock zeros costs one flag.
    static constexpr std::int64_t kBlock = 32;

    /// Weights of magnitudes in the sum that tells the expected magnitude.
    static constexpr std::uint32_t kW = 10, kN = 10, kNW = 5, kNE = 5, kWW = 3, kNN = 3;
    static constexpr std::uint32_t kParent = 2, kParentNear = 1;
    static constexpr std::uint32_t kSibling = 2, kSiblingNear = 1;

    /// Rows of the band's own plane around the row being coded; index 0 is the first column of the
    /// box.
    struct Rows {
        std::uint16_t* at;
        const std::uint16_t* n;
        const std::uint16_t* nn;
        std::int8_t* sign;
        const std::int8_t* sign_n;
        const std::int8_t* sign_nn;
    };

    [[nodiscard]] BandPlane& plane() { return planes_.back(); }

    void code_strip(GridView<std::int32_t> values, std::int64_t first, std::int64_t rows) {
        const std::int64_t row0 = plane().box().row0 + first;
        for (std::int64_t r = 0; r < rows; ++r) look_across(row0 + r, across_.row(r));
        code_flags({values.row(first), rows, values.cols, values.stride});
        for (std::int64_t r = 0; r < rows; ++r)
            code_row(values.row(first + r), row0 + r, across_.row(r));
    }

    /// Sums of the magnitudes around each point of a row in the parent and in the siblings.
    void look_across(std::int64_t row, std::uint32_t* sums) {
        const LatticeBox& box = plane().box();
        std::fill_n(sums, box.cols, 0);
        if (kind_ != 0) return;
        const std::size_t siblings = planes_.size() - 1;
        for (std::size_t k = 0; k < siblings; ++k) add_sibling(planes_[k], row, sums);
        if (siblings > 0) {
            const auto share = static_cast<std::uint32_t>(128 / siblings);
            for (std::int64_t c = 0; c < box.cols; ++c) sums[c] = sums[c] * share >> 6;
        }
        if (parent_) add_parent(*parent_, row, sums);
    }

    void add_sibling(const BandPlane& sibling, std::int64_t row, std::uint32_t* sums) {
        const LatticeBox& box = plane().box();
        const LatticeBox& other = sibling.box();
        const std::int64_t begin = std::max(box.col0, other.col0 - 1);
        const std::int64_t end = std::min(box.col0 + box.cols, other.col0 + other.cols + 1);
        const std::uint16_t* at = sibling.magnitudes(row);
        const std::uint16_t* above = sibling.magnitudes(row - 1);
        const std::uint16_t* below = sibling.magnitudes(row + 1);
        for (std::int64_t j = begin; j < end; ++j) {
            const std::int64_t s = j - other.col0;
            const std::uint32_t near = at[s - 1] + at[s + 1] + above[s] + below[s];
            sums[j - box.col0] += kSibling * at[s] + kSiblingNear * near;
        }
    }

    void add_parent(const BandPlane& parent, std::int64_t row, std::uint32_t* sums) {
        const LatticeBox& box = plane().box();
        const LatticeBox& coarse = parent.box();
        const std::int64_t begin = std::max(box.col0, 2 * (coarse.col0 - 1));
        const std::int64_t end = std::min(box.col0 + box.cols, 2 * (coarse.col0 + coarse.cols + 1));
        const std::uint16_t* at = parent.magnitudes(row >> 1);
        const std::uint16_t* above = parent.magnitudes((row >> 1) - 1);
        const std::uint16_t* below = parent.magnitudes((row >> 1) + 1);
        for (std::int64_t j = begin; j < end; ++j) {
            const std::int64_t p = (j >> 1) - coarse.col0;
            const std::uint32_t near = at[p - 1] + at[p + 1] + above[p] + below[p];
            sums[j - box.col0] += kParent * at[p] + kParentNear * near;
        }
    }

    /// Which blocks of a strip have a value that is not zero. flags_[b + 1] holds block b, of the
    /// strip above before.
    void code_flags(GridView<std::int32_t> strip) {
        for (std::int64_t c = 0; c < strip.cols; c += kBlock) {
            const std::int64_t cols = std::min(kBlock, strip.cols - c);
            bool any = false;
            std::uint64_t activity = 0;
            for (std::int64_t r = 0; r < strip.rows; ++r) {
                const std::uint32_t* across = across_.row(r) + c;
                for (std::int64_t k = 0; k < cols; ++k) activity += across[k];
                const std::int32_t* values = strip.row(r) + c;
                if constexpr (!Coder::kDecodes)
                    any = any || std::any_of(values, values + cols, [](int q) { return q; });
            }
            const auto capped =
                static_cast<std::uint32_t>(std::min<std::uint64_t>(activity, 1U << 17));
            std::uint8_t* flag = &flags_[static_cast<std::size_t>(c / kBlock) + 1];
            const std::uint32_t neighbours = flag[-1] + 2U * flag[0];
            flag[0] = code_adaptive(coder_, any,
                                    model_->block[band_][neighbours][log_class(capped, 63) / 4]);
        }
    }

    void code_row(std::int32_t* values, std::int64_t row, const std::uint32_t* across) {
        const std::int64_t cols = plane().box().cols;
        const Rows rows{plane().magnitudes(row),     plane().magnitudes(row - 1),
                        plane().magnitudes(row - 2), plane().signs(row),
                        plane().signs(row - 1),      plane().signs(row - 2)};
        std::uint32_t* above = above_.data();
        for (std::int64_t c = 0; c < cols; ++c)
            above[c] =
                kN * rows.n[c] + kNW * rows.n[c - 1] + kNE * rows.n[c + 1] + kNN * rows.nn[c];
        for (std::int64_t first = 0; first < cols; first += kBlock) {
            const std::int64_t end = std::min(cols, first + kBlock);
            if (flags_[static_cast<std::size_t>(first / kBlock) + 1]) {
                for (std::int64_t c = first; c < end; ++c) {
                    const std::int32_t q =
                        code_value(values[c], look_around(rows, c, above[c], across[c]));
                    if constexpr (Coder::kDecodes) values[c] = q;
                    BandPlane::set(rows.at[c], rows.sign[c], q);
                }
            } else if constexpr (Coder::kDecodes) {
                std::fill(values + first, values + end, 0);
            }
        }
    }

    static Surroundings look_around(const Rows& rows, std::int64_t c, std::uint32_t above,
                                    std::uint32_t across) {
        const std::uint32_t w = rows.at[c - 1];
        const std::uint32_t n = rows.n[c];
        const std::uint32_t neighbours = above + kW * w + kWW * rows.at[c - 2];
        const std::uint32_t across_class = log_class(across, 4 * LevelModel::kAcross - 1) / 4;
        const std::uint32_t sign_w = sign_class(rows.sign[c - 1]);
        const std::uint32_t sign_n = sign_class(rows.sign_n[c]);
        Surroundings s;
        s.expected = log_class(neighbours + across, LevelModel::kExpected - 1);
        s.sources =
            log_class(neighbours, 4 * LevelModel::kNeighbours - 1) / 4 * LevelModel::kAcross +
            across_class;
        s.pattern = ((few(w) * 3 + few(n)) * 3 + few(rows.n[c - 1])) * 3 + few(rows.n[c + 1]);
        s.pattern = s.pattern * 4 + std::min(across_class, 3U);
        s.nearest = size_class(w) * 6 + size_class(n);
        s.signs_ring = sign_w + 3 * sign_n + 9 * sign_class(rows.sign_n[c - 1]) +
                       27 * sign_class(rows.sign_n[c + 1]);
        s.signs_cross = sign_w + 3 * sign_n + 9 * sign_class(rows.sign[c - 2]) +
                        27 * sign_class(rows.sign_nn[c]);
        s.signs_strong = strong_class(rows.sign[c - 1], w) + 5 * strong_class(rows.sign_n[c], n);
        return s;
    }

    static std::uint32_t few(std::uint32_t magnitude) { return std::min(magnitude, 2U); }
    static std::uint32_t size_class(std::uint32_t m) {
        return m < 3 ? m : m < 5 ? 3U : m < 9 ? 4U : 5U;
    }
    static std::uint32_t sign_class(int sign) { return static_cast<std::uint32_t>(sign + 1); }
    static std::uint32_t strong_class(int sign, std::uint32_t magnitude) {
        return static_cast<std::uint32_t>(2 + (magnitude > 1 ? 2 * sign : sign));
    }

    std::int32_t code_value(std::int32_t q, const Surroundings& s) {
        LevelModel& m = *model_;
        const bool nonzero =
            code_mixed<3>(coder_, q != 0,
                          {&m.zero_expected[band_][s.expected], &m.zero_sources[kind_][s.sources],
                           &m.zero_pattern[kind_][s.pattern]},
                          m.zero_mix, m.zero_refinement[s.expected]);
        if (!nonzero) return 0;
        const bool negative =
            code_mixed<3>(coder_, q < 0,
                          {&m.sign_ring[band_][s.signs_ring], &m.sign_cross[band_][s.signs_cross],
                           &m.sign_strong[band_][s.signs_strong]},
                          m.sign_mix, m.sign_refinement);
        const std::uint32_t magnitude = 1 + code_excess(magnitude_of(q) - 1, s);
        return static_cast<std::int32_t>(negative ? 0U - magnitude : magnitude);
    }

    /// A magnitude less one: its bucket in unary, then its place in the bucket, of which the first
    /// bit is modelled.
    std::uint32_t code_excess(std::uint32_t excess, const Surroundings& s) {
        const std::uint32_t bucket = bucket_of(excess);
        std::uint32_t u = 0;
        while (u < LevelModel::kBuckets && code_beyond(bucket > u, u, s)) ++u;
        if (u < 4) return u;
        const int raw = static_cast<int>(u / 2) - 2;
        const std::uint32_t base = (2 + (u & 1)) << (raw + 1);
        const bool upper =
            code_adaptive(coder_, ((excess - base) >> raw & 1) != 0, model_->place[u]);
        const std::uint32_t low = code_low_bits(coder_, excess - base, raw);
        return base + (static_cast<std::uint32_t>(upper) << raw) + low;
    }

    bool code_beyond(bool beyond, std::uint32_t u, const Surroundings& s) {
        LevelModel& m = *model_;
        const std::uint32_t low = std::min(u, LevelModel::kLowBuckets - 1);
        return code_mixed<3>(
            coder_, beyond,
            {&m.bucket_expected[kind_][u][s.expected], &m.bucket_sources[kind_][low][s.sources],
             &m.bucket_nearest[kind_][low][s.nearest]},
            m.bucket_mix, m.bucket_refinement[u]);
    }

    Coder& coder_;
    std::unique_ptr<LevelModel> model_;
    std::vector<BandPlane> parents_;
    std::vector<BandPlane> planes_;  ///< of the bands coded so far, the last being coded
    const BandPlane* parent_ = nullptr;
    std::uint32_t band_ = 0;
    std::uint32_t kind_ = 0;
    Grid<std::uint32_t> across_;        ///< a strip of look_across
    std::vector<std::uint32_t> above_;  ///< weighted magnitudes of the rows above
    std::vector<std::uint8_t> flags_;
};

}  // namespace relief::codec
