#include "codec/corrections.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "codec/bytes.h"
#include "codec/probability.h"
#include "codec/range_coder.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

/// The place of a float among all floats of its type: neighbours differ by 1, -0 lies just below 0.
std::uint64_t order_of(double value, SampleType type) {
    if (type == SampleType::Float32) {
        const auto single = static_cast<float>(value);
        std::uint32_t bits = 0;
        std::memcpy(&bits, &single, sizeof bits);
        return bits >> 31 ? 0xFFFFFFFFU - bits : bits + 0x80000000U;
    }
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return bits >> 63 ? ~bits : bits + 0x8000000000000000U;
}

double float_at(std::uint64_t order, SampleType type) {
    if (type == SampleType::Float32) {
        const auto place = static_cast<std::uint32_t>(order);
        const std::uint32_t bits = place >> 31 ? place - 0x80000000U : 0xFFFFFFFFU - place;
        float single = 0;
        std::memcpy(&single, &bits, sizeof bits);
        return single;
    }
    const std::uint64_t bits = order >> 63 ? order - 0x8000000000000000U : ~order;
    double value = 0;
    std::memcpy(&value, &bits, sizeof bits);
    return value;
}

/// How one sample is corrected; shared by encoder and decoder.
struct Rule {
    bool ordered;
    double step;
    SampleType type;
    std::optional<double> nodata;

    [[nodiscard]] double base(double surface) const {
        return ordered || is_integer(type) ? stored_value(surface, type, nodata) : surface;
    }
    [[nodiscard]] double corrected(double surface, std::int64_t k) const {
        if (ordered)
            return float_at(order_of(base(surface), type) + static_cast<std::uint64_t>(k), type);
        return stored_value(base(surface) + static_cast<double>(k) * step, type, nodata);
    }
};

bool same_bits(double a, double b) {
    return a == b && std::signbit(a) == std::signbit(b);
}

/// The k that brings `surface` within `bound` of `value`; found false when none does.
std::int64_t choose_k(const Rule& rule, double surface, double value, double bound, bool& found) {
    found = true;
    // Exact floats are exact in the sign of zero too.
    const double uncorrected = rule.corrected(surface, 0);
    if (rule.ordered ? same_bits(uncorrected, value) : std::abs(uncorrected - value) <= bound)
        return 0;
    if (rule.ordered)
        return static_cast<std::int64_t>(order_of(value, rule.type) -
                                         order_of(rule.base(surface), rule.type));
    const double wanted = std::nearbyint((value - rule.base(surface)) / rule.step);
    if (std::abs(wanted) < 0x1p62) {
        const auto nearest = static_cast<std::int64_t>(wanted);
        for (const std::int64_t k : {nearest, nearest - 1, nearest + 1})
            if (std::abs(rule.corrected(surface, k) - value) <= bound) return k;
    }
    found = false;
    return 0;
}

std::uint64_t magnitude_of(std::int64_t k) {
    const auto bits = static_cast<std::uint64_t>(k);
    return k < 0 ? 0 - bits : bits;
}

/// Codes the k of one component, row by row, each in the light of those to the west and above.
template <class Coder>
class CorrectionCoder {
  public:
    CorrectionCoder(Coder& coder, std::int64_t cols)
        : coder_(coder), row_(static_cast<std::size_t>(cols) + 2), above_(row_) {}

    void code_row(std::int64_t* ks) {
        for (std::size_t c = 1; c + 1 < row_.size(); ++c) row_[c] = code(ks[c - 1], c);
        if constexpr (Coder::kDecodes) std::copy_n(&row_[1], row_.size() - 2, ks);
        above_.swap(row_);
    }

  private:
    static constexpr std::size_t kWidths = 65;

    std::int64_t code(std::int64_t k, std::size_t c) {
        const std::uint64_t w = magnitude_of(row_[c - 1]);
        const std::uint64_t n = magnitude_of(above_[c]);
        const auto few = [](std::uint64_t m) {
            return static_cast<std::size_t>(std::min<std::uint64_t>(m, 2));
        };
        const std::size_t around = 27 * few(w) + 9 * few(n) + 3 * few(magnitude_of(above_[c - 1])) +
                                   few(magnitude_of(above_[c + 1]));
        if (!code_adaptive(coder_, k != 0, zero_[around])) return 0;
        const std::size_t signs = 3 * sign_class(row_[c - 1]) + sign_class(above_[c]);
        const bool negative = code_adaptive(coder_, k < 0, sign_[signs]);
        const std::size_t expected = static_cast<std::size_t>(std::bit_width(w / 2 + n / 2));
        const std::uint64_t size = code_excess(magnitude_of(k) - 1, expected) + 1;
        return static_cast<std::int64_t>(negative ? 0 - size : size);
    }

    static std::size_t sign_class(std::int64_t k) { return k < 0 ? 0 : k == 0 ? 1 : 2; }

    /// The number of bits in unary, then those behind the leading one.
    std::uint64_t code_excess(std::uint64_t e, std::size_t expected) {
        const auto wanted = static_cast<std::size_t>(std::bit_width(e));
        std::size_t width = 0;
        while (width + 1 < kWidths &&
               code_adaptive(coder_, width < wanted, width_[expected][width]))
            ++width;
        if (width < 2) return width;
        std::uint64_t value = 1;
        for (auto left = static_cast<int>(width) - 1; left > 0;) {
            const int count = std::min(left, 16);
            left -= count;
            const std::uint64_t mask = (std::uint64_t{1} << count) - 1;
            const auto bits = static_cast<std::uint32_t>(e >> left & mask);
            value = value << count | coder_.code_raw(bits, count);
        }
        return value;
    }

    Coder& coder_;
    std::vector<std::int64_t> row_;  ///< with a zero on either side
    std::vector<std::int64_t> above_;
    std::array<Slot, 81> zero_;
    std::array<Slot, 9> sign_;
    std::array<std::array<Slot, kWidths>, kWidths> width_;
};

}  // namespace

Corrections make_corrections(const Raster& original, const multires::Planes<double>& surface,
                             double bound) {
    Corrections result;
    const bool integer = is_integer(original.type);
    result.ordered = !integer && bound == 0;
    // Just under two bounds, so that rounding in the last place does not break the bound.
    result.step = integer          ? 2 * std::floor(bound) + 1
                  : result.ordered ? 1
                                   : 2 * bound * (1 - 0x1p-20);
    const Rule rule{result.ordered, result.step, original.type, original.nodata};
    for (std::size_t p = 0; p < surface.size(); ++p) {
        Grid<std::int64_t> ks(original.rows, original.cols);
        std::vector<std::vector<Corrections::Repair>> repairs(
            static_cast<std::size_t>(original.rows));
        const auto correct = [&](std::int64_t r, std::int64_t c) {
            if (!original.valid(r, c)) return std::int64_t{0};
            const double value = original.planes[p](r, c);
            bool found = true;
            const std::int64_t k = choose_k(rule, surface[p](r, c), value, bound, found);
            if (!found)
                repairs[static_cast<std::size_t>(r)].push_back(
                    {static_cast<std::uint8_t>(p),
                     static_cast<std::uint64_t>(r * original.cols + c), value});
            return k;
        };
        parallel_for(0, original.rows, 32, [&](std::int64_t first, std::int64_t last) {
            for (std::int64_t r = first; r < last; ++r)
                for (std::int64_t c = 0; c < original.cols; ++c) ks(r, c) = correct(r, c);
        });
        for (const auto& row : repairs)
            result.repairs.insert(result.repairs.end(), row.begin(), row.end());
        for (std::int64_t r = 0; r < original.rows; ++r)
            result.corrected += original.cols - std::count(ks.row(r), ks.row(r) + original.cols, 0);
        result.planes.push_back(std::move(ks));
    }
    result.corrected += static_cast<std::int64_t>(result.repairs.size());
    return result;
}

void apply_corrections(const Corrections& corrections, SampleType type,
                       std::optional<double> nodata, const LatticeBox& window,
                       multires::Planes<double>& surface) {
    const Rule rule{corrections.ordered, corrections.step, type, nodata};
    for (std::size_t p = 0; p < surface.size(); ++p) {
        Grid<double>& plane = surface[p];
        parallel_for(0, plane.rows(), 32, [&](std::int64_t first, std::int64_t last) {
            for (std::int64_t r = first; r < last; ++r) {
                const std::int64_t* ks = corrections.planes[p].row(window.row0 + r) + window.col0;
                for (std::int64_t c = 0; c < plane.cols(); ++c)
                    if (ks[c] != 0) plane(r, c) = rule.corrected(plane(r, c), ks[c]);
            }
        });
    }
    for (const Corrections::Repair& repair : corrections.repairs) {
        const auto cols = static_cast<std::uint64_t>(corrections.planes[0].cols());
        const auto row = static_cast<std::int64_t>(repair.index / cols);
        const auto col = static_cast<std::int64_t>(repair.index % cols);
        if (window.contains(row, col))
            surface[repair.component](row - window.row0, col - window.col0) = repair.value;
    }
}

Bytes write_corrections(const Corrections& corrections) {
    ByteWriter out;
    out.u8(corrections.ordered ? 1 : 0);
    out.f64(corrections.step);
    out.varint(corrections.repairs.size());
    for (const Corrections::Repair& repair : corrections.repairs) {
        out.u8(repair.component);
        out.u64(repair.index);
        out.f64(repair.value);
    }
    RangeEncoder encoder;
    for (const Grid<std::int64_t>& plane : corrections.planes) {
        CorrectionCoder coder(encoder, plane.cols());
        std::vector<std::int64_t> row(static_cast<std::size_t>(plane.cols()));
        for (std::int64_t r = 0; r < plane.rows(); ++r) {
            std::copy_n(plane.row(r), plane.cols(), row.begin());
            coder.code_row(row.data());
        }
    }
    out.bytes(encoder.finish());
    return out.take();
}

Result<Corrections> read_corrections(std::span<const std::uint8_t> bytes, std::int64_t rows,
                                     std::int64_t cols, int components) {
    const Error damaged{ErrorCode::BadFile,
                        "the corrections are damaged; decode a coarser level instead",
                        "correction chunk"};
    ByteReader in(bytes);
    Corrections result;
    const std::uint8_t mode = in.u8();
    result.ordered = mode == 1;
    result.step = in.f64();
    const std::uint64_t repairs = in.varint();
    constexpr std::uint64_t repair_size = 17;
    if (in.failed() || mode > 1 || !std::isfinite(result.step) ||
        repairs > in.rest().size() / repair_size)
        return damaged;
    for (std::uint64_t k = 0; k < repairs; ++k) {
        Corrections::Repair repair{in.u8(), in.u64(), in.f64()};
        if (repair.component >= components ||
            repair.index >= static_cast<std::uint64_t>(rows * cols))
            return damaged;
        result.repairs.push_back(repair);
    }
    RangeDecoder decoder(in.rest());
    for (int p = 0; p < components; ++p) {
        Grid<std::int64_t>& plane = result.planes.emplace_back(rows, cols);
        CorrectionCoder coder(decoder, cols);
        for (std::int64_t r = 0; r < rows && !decoder.ran_out(); ++r) coder.code_row(plane.row(r));
    }
    if (!decoder.at_end()) return damaged;
    return result;
}

}  // namespace relief::codec
