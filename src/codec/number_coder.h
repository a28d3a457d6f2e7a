#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "codec/embedded_mixing.h"
#include "codec/probability.h"
#include "codec/range_coder.h"

namespace relief::codec {

/// Sums over numbers around the one to be coded.
struct Surrounding {
    std::uint64_t magnitude = 0;
    std::int64_t balance = 0;  ///< of the signs
    std::uint32_t count = 0;

    void add(std::int64_t q) {
        constexpr std::uint64_t most = std::uint64_t{1} << 32;
        const auto bits = static_cast<std::uint64_t>(q);
        magnitude += std::min(q < 0 ? 0 - bits : bits, most);
        balance += (q > 0) - (q < 0);
        ++count;
    }
    void add(const Surrounding& other) {
        magnitude += other.magnitude;
        balance += other.balance;
        count += other.count;
    }
};

/// What the coder of numbers on meshes has learnt. docs/format.md, "Numbers".
struct NumberModel {
    static constexpr std::uint32_t kKinds = 10;
    static constexpr std::uint32_t kClasses = 80;
    static constexpr std::uint32_t kLengths = 64;
    static constexpr std::uint32_t kUnknown = 12;  ///< class where there is nothing around

    /// [kind][class][length], [class][length]
    std::vector<Chance> near, far, both;
    std::array<std::array<Slot, 3>, kKinds> sign;
    std::array<std::array<Slot, kLengths + 1>, 2> lead;  ///< the bits behind the leading one
    std::array<Blend<3>, kKinds> by_kind;
    std::array<Blend<3>, kLengths> by_length;

    NumberModel() {
        const std::vector<Chance> one_kind = chances_of_all_classes();
        both = one_kind;
        for (std::uint32_t kind = 0; kind < kKinds; ++kind)
            near.insert(near.end(), one_kind.begin(), one_kind.end());
        far = near;
    }

    /// The mean magnitude in half octaves of its eighths.
    static std::uint32_t class_of(const Surrounding& s) {
        if (s.count == 0) return kUnknown;
        const std::uint64_t eighths = 8 * s.magnitude / s.count;
        if (eighths < 2) return static_cast<std::uint32_t>(eighths);
        const auto octave = static_cast<std::uint32_t>(std::bit_width(eighths)) - 1;
        const auto half = static_cast<std::uint32_t>(eighths >> (octave - 1) & 1);
        return std::min(2 * octave + half, kClasses - 1);
    }

    static std::size_t place(std::uint32_t c, std::uint32_t length) {
        return static_cast<std::size_t>(c) * kLengths + length;
    }
    static std::size_t place(std::uint32_t kind, std::uint32_t c, std::uint32_t length) {
        return place(kind * kClasses + c, length);
    }

  private:
    /// Magnitudes of mean e decay like (e / (e + 1))^|q|; a start that few numbers never outgrow.
    static std::vector<Chance> chances_of_all_classes() {
        std::vector<Chance> chances;
        for (std::uint32_t c = 0; c < kClasses; ++c) {
            const std::uint64_t eighths =
                1 + (c < 2 ? c : std::uint64_t{2 + (c & 1)} << (c / 2) >> 1);
            std::uint64_t longer =
                (std::min<std::uint64_t>(eighths, 1 << 30) << 32) / (eighths + 8);
            for (std::uint32_t length = 0; length < kLengths; ++length) {
                if (length > 1) longer = longer * longer >> 32;
                longer = std::max<std::uint64_t>(longer, 1 << 20);
                chances.push_back({static_cast<std::uint32_t>(longer), 3});
            }
        }
        return chances;
    }
};

/// Codes integers of 64 bits, one text for encoder and decoder: see range_coder.h.
template <class Coder>
class NumberCoder {
  public:
    NumberCoder(Coder& coder, NumberModel& model) : coder_(coder), model_(model) {}

    /// `near`: numbers around it that are known; `far`: those around it one level below.
    std::int64_t code(std::int64_t q, std::uint32_t kind, const Surrounding& near,
                      const Surrounding& far) {
        const auto bits = static_cast<std::uint64_t>(q);
        const std::uint64_t magnitude = code_magnitude(q < 0 ? 0 - bits : bits, kind, near, far);
        if (magnitude == 0) return 0;
        const std::size_t balance = near.balance < 0 ? 0 : near.balance > 0 ? 2 : 1;
        const bool negative = code_adaptive(coder_, q < 0, model_.sign[kind][balance]);
        return static_cast<std::int64_t>(negative ? 0 - magnitude : magnitude);
    }

  private:
    /// How many bits it has, in unary, then those behind the leading one.
    std::uint64_t code_magnitude(std::uint64_t magnitude, std::uint32_t kind,
                                 const Surrounding& near, const Surrounding& far) {
        const auto bits = static_cast<std::uint32_t>(std::bit_width(magnitude));
        const std::uint32_t near_class = NumberModel::class_of(near);
        const std::uint32_t far_class = NumberModel::class_of(far);
        Surrounding all = near;
        all.add(far);
        const std::uint32_t all_class = NumberModel::class_of(all);
        std::uint32_t length = 0;
        while (length < NumberModel::kLengths) {
            const bool longer =
                code_blended<3>(coder_, bits > length,
                                {&model_.near[NumberModel::place(kind, near_class, length)],
                                 &model_.far[NumberModel::place(kind, far_class, length)],
                                 &model_.both[NumberModel::place(all_class, length)]},
                                model_.by_kind[kind], model_.by_length[length]);
            if (!longer) break;
            ++length;
        }
        return length < 2 ? length : code_behind_leading(magnitude, length);
    }

    std::uint64_t code_behind_leading(std::uint64_t magnitude, std::uint32_t length) {
        std::uint64_t known = 1;
        auto rest = static_cast<int>(length) - 1;
        for (std::size_t k = 0; k < 2 && rest > 0; ++k) {
            --rest;
            const bool bit =
                code_adaptive(coder_, (magnitude >> rest & 1) != 0, model_.lead[k][length]);
            known = known << 1 | static_cast<std::uint64_t>(bit);
        }
        while (rest > 0) {
            const int some = std::min(rest, 16);
            rest -= some;
            const auto part =
                static_cast<std::uint32_t>(magnitude >> rest & ((std::uint64_t{1} << some) - 1));
            known = known << some | coder_.code_raw(part, some);
        }
        return known;
    }

    Coder& coder_;
    NumberModel& model_;
};

}  // namespace relief::codec
