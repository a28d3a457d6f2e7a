#include "relief/core/raster.h"
#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/stored_row.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef RELIEF_CORE_STORED_ROW_ONCE
#define RELIEF_CORE_STORED_ROW_ONCE
#include <cmath>
#include <limits>

namespace relief {

inline void stored_row_scalar(const double* values, std::int64_t n, SampleType type,
                              std::optional<double> nodata, double* out) {
    for (std::int64_t k = 0; k < n; ++k) out[k] = stored_value(values[k], type, nodata);
}

}  // namespace relief
#endif

HWY_BEFORE_NAMESPACE();
namespace relief {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::ScalableTag<double>;

/// Whole vectors are rounded by round(v) and stored if none of them meets nodata, which is rare;
/// the others and the rest of the row are left to the scalar rule. meets(v): may read as nodata.
template <class Round, class Meets>
HWY_INLINE void store_vectors(const double* values, std::int64_t n, SampleType type,
                              std::optional<double> nodata, Round round, Meets meets, double* out) {
    const Doubles d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    std::int64_t k = 0;
    for (; k + lanes <= n; k += lanes) {
        const auto rounded = round(hn::LoadU(d, values + k));
        if (nodata && meets(rounded)) {
            stored_row_scalar(values + k, lanes, type, nodata, out + k);
        } else {
            hn::StoreU(rounded, d, out + k);
        }
    }
    stored_row_scalar(values + k, n - k, type, nodata, out + k);
}

void stored_vectors(const double* values, std::int64_t n, SampleType type,
                    std::optional<double> nodata, double* out) {
    const Doubles d;
    const auto [low, high] = sample_range(type);
    const auto lowest = hn::Set(d, low);
    const auto highest = hn::Set(d, high);
    if (nodata && std::isnan(*nodata)) nodata.reset();  // no value reads as that
    const double read = nodata.value_or(0);
    const bool narrow = type == SampleType::Float32;
    const auto hole = hn::Set(d, narrow ? static_cast<double>(static_cast<float>(read)) : read);
    const auto clamped = [&](hn::Vec<Doubles> v)
                             HWY_ATTR { return hn::Min(hn::Max(v, lowest), highest); };
    if (is_integer(type)) {
        const auto round = [&](hn::Vec<Doubles> v)
                               HWY_ATTR { return hn::Add(hn::Round(clamped(v)), hn::Zero(d)); };
        const auto meets = [&](hn::Vec<Doubles> v)
                               HWY_ATTR { return !hn::AllFalse(d, hn::Eq(v, hole)); };
        return store_vectors(values, n, type, nodata, round, meets, out);
    }
    // Twice the tolerance of readers, so that rounding in float does not matter; where their sum
    // overflows, their tolerance is infinite.
    const auto tolerance =
        hn::Set(d, 4.0 * static_cast<double>(std::numeric_limits<float>::epsilon()));
    const auto overflow = hn::Set(d, high * (1 + 0x1p-26));
    const auto meets = [&](hn::Vec<Doubles> v) HWY_ATTR {
        const auto sum = hn::Add(hn::Abs(v), hn::Abs(hole));
        const auto far = hn::Gt(hn::Abs(hn::Sub(v, hole)), hn::Mul(tolerance, sum));
        return !hn::AllTrue(d, hn::And(far, hn::Le(sum, overflow)));
    };
    if (!narrow) return store_vectors(values, n, type, nodata, clamped, meets, out);
    const hn::Rebind<float, Doubles> df;
    const auto round = [&](hn::Vec<Doubles> v)
                           HWY_ATTR { return hn::PromoteTo(d, hn::DemoteTo(df, clamped(v))); };
    store_vectors(values, n, type, nodata, round, meets, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace relief
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief {

namespace {
HWY_EXPORT(stored_vectors);
}  // namespace

void stored_row(const double* values, std::int64_t n, SampleType type, std::optional<double> nodata,
                double* out) {
    if (!simd_enabled()) return stored_row_scalar(values, n, type, nodata, out);
    HWY_DYNAMIC_DISPATCH(stored_vectors)(values, n, type, nodata, out);
}

}  // namespace relief
#endif  // HWY_ONCE
