#include "codec/corrections.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "codec/bytes.h"
#include "relief/codec/band_coder.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

constexpr int kDigitBits = 22;
constexpr int kMostDigits = 3;

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

std::int64_t digit_of(std::int64_t& rest) {
    constexpr std::int64_t base = std::int64_t{1} << kDigitBits;
    std::int64_t digit = ((rest % base) + base) % base;
    if (digit >= base / 2) digit -= base;
    // Exact division; unsigned so that the extremes wrap instead of overflowing.
    rest = static_cast<std::int64_t>(static_cast<std::uint64_t>(rest) -
                                     static_cast<std::uint64_t>(digit)) >>
           kDigitBits;
    return digit;
}

int digits_for(std::int64_t value) {
    int digits = 0;
    do {
        digit_of(value);
        ++digits;
    } while (value != 0 && digits < kMostDigits);
    return digits;
}

/// The k that brings `surface` within `bound` of `value`; found false when none does.
std::int64_t choose_k(const Rule& rule, double surface, double value, double bound, bool& found) {
    found = true;
    if (std::abs(rule.corrected(surface, 0) - value) <= bound) return 0;
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

bool same_bits(double a, double b) {
    return a == b && std::signbit(a) == std::signbit(b);
}

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
    const std::size_t components = surface.size();
    std::vector<Grid<std::int64_t>> chosen;
    for (std::size_t p = 0; p < components; ++p) {
        Grid<std::int64_t> ks(original.rows, original.cols);
        std::vector<std::vector<Corrections::Repair>> repairs(
            static_cast<std::size_t>(original.rows));
        parallel_for(0, original.rows, 32, [&](std::int64_t first, std::int64_t last) {
            for (std::int64_t r = first; r < last; ++r)
                for (std::int64_t c = 0; c < original.cols; ++c) {
                    ks(r, c) = 0;
                    if (!original.valid(r, c)) continue;
                    const double value = original.planes[p](r, c);
                    bool found = true;
                    std::int64_t k = choose_k(rule, surface[p](r, c), value, bound, found);
                    // Exact floats are exact in the sign of zero too.
                    if (result.ordered && k == 0 &&
                        !same_bits(rule.corrected(surface[p](r, c), 0), value))
                        k = static_cast<std::int64_t>(
                            order_of(value, rule.type) -
                            order_of(rule.base(surface[p](r, c)), rule.type));
                    ks(r, c) = k;
                    if (!found)
                        repairs[static_cast<std::size_t>(r)].push_back(
                            {static_cast<std::uint8_t>(p),
                             static_cast<std::uint64_t>(r * original.cols + c), value});
                }
        });
        for (const auto& row : repairs)
            result.repairs.insert(result.repairs.end(), row.begin(), row.end());
        for (std::int64_t r = 0; r < original.rows; ++r)
            for (std::int64_t c = 0; c < original.cols; ++c) {
                result.corrected += ks(r, c) != 0;
                result.digits = std::max(result.digits, digits_for(ks(r, c)));
            }
        chosen.push_back(std::move(ks));
    }
    result.corrected += static_cast<std::int64_t>(result.repairs.size());
    for (const auto& ks : chosen) {
        std::vector<Grid<std::int32_t>> digits;
        for (int d = 0; d < result.digits; ++d) digits.emplace_back(original.rows, original.cols);
        for (std::int64_t r = 0; r < original.rows; ++r)
            for (std::int64_t c = 0; c < original.cols; ++c) {
                std::int64_t rest = ks(r, c);
                for (auto& digit : digits) digit(r, c) = static_cast<std::int32_t>(digit_of(rest));
            }
        for (auto& digit : digits) result.planes.push_back(std::move(digit));
    }
    return result;
}

void apply_corrections(const Corrections& corrections, SampleType type,
                       std::optional<double> nodata, multires::Planes<double>& surface) {
    const Rule rule{corrections.ordered, corrections.step, type, nodata};
    for (std::size_t p = 0; p < surface.size(); ++p) {
        Grid<double>& plane = surface[p];
        parallel_for(0, plane.rows(), 32, [&](std::int64_t first, std::int64_t last) {
            for (std::int64_t r = first; r < last; ++r)
                for (std::int64_t c = 0; c < plane.cols(); ++c) {
                    std::uint64_t k = 0;
                    for (int d = corrections.digits - 1; d >= 0; --d)
                        k = (k << kDigitBits) +
                            static_cast<std::uint64_t>(static_cast<std::int64_t>(
                                corrections
                                    .planes[p * static_cast<std::size_t>(corrections.digits) +
                                            static_cast<std::size_t>(d)](r, c)));
                    if (k != 0)
                        plane(r, c) = rule.corrected(plane(r, c), static_cast<std::int64_t>(k));
                }
        });
    }
    for (const Corrections::Repair& repair : corrections.repairs) {
        const auto cols = static_cast<std::uint64_t>(surface[0].cols());
        surface[repair.component](static_cast<std::int64_t>(repair.index / cols),
                                  static_cast<std::int64_t>(repair.index % cols)) = repair.value;
    }
}

std::vector<std::uint8_t> write_corrections(const Corrections& corrections) {
    ByteWriter out;
    out.u8(corrections.ordered ? 1 : 0);
    out.u8(static_cast<std::uint8_t>(corrections.digits));
    out.f64(corrections.step);
    out.u64(corrections.repairs.size());
    for (const Corrections::Repair& repair : corrections.repairs) {
        out.u8(repair.component);
        out.u64(repair.index);
        out.f64(repair.value);
    }
    std::vector<BandView> bands;
    for (const Grid<std::int32_t>& plane : corrections.planes)
        bands.push_back({{0, 0, plane.rows(), plane.cols()},
                         {const_cast<std::int32_t*>(plane.row(0)), plane.rows(), plane.cols(),
                          plane.stride()}});
    out.bytes(encode_level(bands, {}));
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
    result.digits = in.u8();
    result.step = in.f64();
    const std::uint64_t repairs = in.u64();
    constexpr std::uint64_t repair_size = 17;
    if (in.failed() || mode > 1 || result.digits < 1 || result.digits > kMostDigits ||
        !std::isfinite(result.step) || repairs > in.rest().size() / repair_size)
        return damaged;
    for (std::uint64_t k = 0; k < repairs; ++k) {
        Corrections::Repair repair{in.u8(), in.u64(), in.f64()};
        if (repair.component >= components ||
            repair.index >= static_cast<std::uint64_t>(rows * cols))
            return damaged;
        result.repairs.push_back(repair);
    }
    std::vector<BandView> bands;
    for (int k = 0; k < components * result.digits; ++k) result.planes.emplace_back(rows, cols);
    for (Grid<std::int32_t>& plane : result.planes)
        bands.push_back({{0, 0, rows, cols}, plane.view()});
    RELIEF_CHECK(decode_level(in.rest(), bands, {}));
    return result;
}

}  // namespace relief::codec
