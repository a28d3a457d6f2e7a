#include "codec/lattice_base.h"

#include <algorithm>
#include <bit>

#include "codec/range_coder.h"

namespace relief::codec {

namespace {

/// That a number has one more bit: times 65536.
constexpr std::uint32_t kLonger = 52000;
constexpr int kMostBits = 32;
constexpr std::int64_t kLargest = std::int64_t{1} << 29;

/// Exp-Golomb: how many bits follow the leading one, in unary, then they.
template <class Coder>
std::uint64_t code_number(Coder& coder, std::uint64_t number) {
    const int bits = std::bit_width(number) - 1;
    int length = 0;
    while (length < kMostBits && coder.code(length < bits, kLonger)) ++length;
    std::uint64_t result = 1;
    for (int k = length; k > 0;) {
        const int some = std::min(k, 16);
        k -= some;
        const auto part = static_cast<std::uint32_t>(number >> k & ((1U << some) - 1));
        result = result << some | coder.code_raw(part, some);
    }
    return result;
}

/// Signed numbers as 1, 2, 3 ..: 0, -1, 1, -2, ..
std::uint64_t folded(std::int64_t q) {
    return static_cast<std::uint64_t>(q < 0 ? -2 * q : 2 * q + 1);
}
std::int64_t unfolded(std::uint64_t u) {
    const auto half = static_cast<std::int64_t>(u >> 1);
    return u & 1 ? half : -half;
}

std::int64_t nearest_quotient(std::int64_t residual, std::int64_t step) {
    const std::int64_t q = (std::abs(residual) + (step - 1) / 2) / step;
    return residual < 0 ? -q : q;
}

template <class Coder>
void code_base(Coder& coder, LatticeLevel& level, const GridView<const std::int32_t>* source) {
    MarginGrid<std::int32_t>& v = level.values;
    for (std::int64_t r = 0; r < level.rows(); ++r)
        for (std::int64_t c = 0; c < level.cols(); ++c) {
            std::int64_t predicted = (std::int64_t{level.lowest} + level.highest) / 2;
            if (r > 0 && c > 0)
                predicted = std::int64_t{v(r, c - 1)} + v(r - 1, c) - v(r - 1, c - 1);
            else if (c > 0)
                predicted = v(r, c - 1);
            else if (r > 0)
                predicted = v(r - 1, c);
            predicted = std::clamp<std::int64_t>(predicted, level.lowest, level.highest);
            std::int64_t q = 0;
            if (level.valid(r, c)) {
                if (source) q = nearest_quotient((*source)(r, c) - predicted, level.step);
                q = unfolded(code_number(coder, folded(q)));
            }
            v(r, c) = static_cast<std::int32_t>(
                std::clamp(predicted + q * level.step, -kLargest, 2 * kLargest));
        }
}

}  // namespace

Bytes encode_base(LatticeLevel& level, GridView<const std::int32_t> source) {
    RangeEncoder coder;
    code_base(coder, level, &source);
    return coder.finish();
}

Status decode_base(std::span<const std::uint8_t> bytes, LatticeLevel& level) {
    RangeDecoder coder(bytes);
    code_base(coder, level, nullptr);
    if (coder.at_end()) return {};
    return Error{ErrorCode::BadFile, "the base lattice does not end where its bytes do",
                 "base lattice"};
}

}  // namespace relief::codec
