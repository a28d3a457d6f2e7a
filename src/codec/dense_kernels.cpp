#include "codec/dense_kernels.h"

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "codec/dense_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace relief::codec::dense {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// At most eight lanes, so that kSlack and the 16 unknowns are whole vectors everywhere.
using Doubles = hn::CappedTag<double, 8>;

void weighted_sum_vector(std::span<const Tap> taps, std::size_t count, double* HWY_RESTRICT out) {
    const Doubles d;
    const hn::Rebind<std::int32_t, Doubles> d32;
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t k = 0; k < count; k += lanes) {
        auto sum = hn::Zero(d);
        for (const Tap& tap : taps) {
            hn::Vec<decltype(d32)> even;
            hn::Vec<decltype(d32)> odd;
            hn::LoadInterleaved2(d32, tap.samples + 2 * k, even, odd);
            sum = hn::Add(sum, hn::Mul(hn::Set(d, tap.weight), hn::PromoteTo(d, even)));
        }
        hn::StoreU(sum, d, out + k);
    }
}

/// Rows `first` to first + kRows - 1 of the sums, up to the column of the last.
template <std::size_t kRows>
HWY_INLINE void add_rows(std::span<const Equation> equations, std::size_t first,
                         NormalEquations& normal) {
    const Doubles d;
    const std::size_t end = std::min(first + kRows, kUnknowns);
    for (std::size_t j = 0; j < end; j += hn::Lanes(d)) {
        hn::Vec<Doubles> sums[kRows];
        for (std::size_t i = 0; i < kRows; ++i) sums[i] = hn::LoadU(d, &normal[first + i][j]);
        for (const Equation& equation : equations) {
            const auto features = hn::LoadU(d, &equation.features[j]);
            for (std::size_t i = 0; i < kRows; ++i)
                sums[i] =
                    hn::Add(sums[i], hn::Mul(hn::Set(d, equation.weighted[first + i]), features));
        }
        for (std::size_t i = 0; i < kRows; ++i) hn::StoreU(sums[i], d, &normal[first + i][j]);
    }
}

void add_equations_vector(std::span<const Equation> equations, NormalEquations& normal) {
    for (std::size_t i = 0; i < kUnknowns; i += 4) add_rows<4>(equations, i, normal);
    add_rows<1>(equations, kUnknowns, normal);
}

}  // namespace HWY_NAMESPACE
}  // namespace relief::codec::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::codec::dense {

namespace {

void weighted_sum_scalar(std::span<const Tap> taps, std::size_t count, double* out) {
    for (std::size_t k = 0; k < count; ++k) {
        double sum = 0;
        for (const Tap& tap : taps) sum += tap.weight * tap.samples[2 * k];
        out[k] = sum;
    }
}

void add_equations_scalar(std::span<const Equation> equations, NormalEquations& normal) {
    for (const Equation& equation : equations)
        for (std::size_t i = 0; i <= kUnknowns; ++i)
            for (std::size_t j = 0; j <= i && j < kUnknowns; ++j)
                normal[i][j] += equation.weighted[i] * equation.features[j];
}

HWY_EXPORT(weighted_sum_vector);
HWY_EXPORT(add_equations_vector);

}  // namespace

void weighted_sum(std::span<const Tap> taps, std::size_t count, double* out) {
    simd_enabled() ? HWY_DYNAMIC_DISPATCH(weighted_sum_vector)(taps, count, out)
                   : weighted_sum_scalar(taps, count, out);
}

void add_equations(std::span<const Equation> equations, NormalEquations& normal) {
    simd_enabled() ? HWY_DYNAMIC_DISPATCH(add_equations_vector)(equations, normal)
                   : add_equations_scalar(equations, normal);
}

}  // namespace relief::codec::dense
#endif  // HWY_ONCE
