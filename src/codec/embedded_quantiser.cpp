#include "codec/embedded_quantiser.h"

#include <algorithm>
#include <cmath>

#include "codec/magnitude.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

constexpr double kRounding = 0.45;
constexpr double kLargest = 2147483647;
constexpr double kWorthUnits = 64;
constexpr std::int64_t kGrain = 64;

}  // namespace

template <class T>
void quantise_band(GridView<const T> c, double step, GridView<std::int32_t> q,
                   GridView<std::uint8_t> worth) {
    parallel_for(0, c.rows, kGrain, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r) {
            const T* from = c.row(r);
            std::int32_t* to = q.row(r);
            std::uint8_t* gain = worth.row(r);
            for (std::int64_t k = 0; k < c.cols; ++k) {
                const double steps = std::abs(static_cast<double>(from[k])) / step;
                const auto size = static_cast<std::int32_t>(std::min(steps + kRounding, kLargest));
                to[k] = from[k] < 0 ? -size : size;
                // steps^2 - (steps - 1)^2 = 2 steps - 1, from 0.1 to 2.1.
                const double more = size == 1 ? kWorthUnits * (2 * steps - 1) + 0.5 : 0;
                gain[k] = static_cast<std::uint8_t>(static_cast<std::int32_t>(more));
            }
        }
    });
}

template <class T>
void reconstruct_band(GridView<const std::int32_t> q, const KnownBits& known, double step,
                      GridView<T> c) {
    const double half = known.plane == 0 ? 0 : 0.5 * static_cast<double>(1U << known.plane);
    // Pass 1 has just begun the values of one bit; the bits of the others end a plane higher.
    const bool mixed = known.pass == 1;
    const double higher = mixed ? 0.5 * static_cast<double>(2U << known.plane) : half;
    const std::uint32_t begun = std::uint32_t{2} << known.plane;
    parallel_for(0, q.rows, kGrain, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r) {
            const std::int32_t* from = q.row(r);
            T* to = c.row(r);
            for (std::int64_t k = 0; k < q.cols; ++k) {
                const std::uint32_t size = magnitude_of(from[k]);
                const double middle = size == 0 ? 0 : size < begun ? half : higher;
                const double value = (static_cast<double>(size) + middle) * step;
                to[k] = static_cast<T>(from[k] < 0 ? -value : value);
            }
        }
    });
}

template void quantise_band(GridView<const float>, double, GridView<std::int32_t>,
                            GridView<std::uint8_t>);
template void quantise_band(GridView<const double>, double, GridView<std::int32_t>,
                            GridView<std::uint8_t>);
template void reconstruct_band(GridView<const std::int32_t>, const KnownBits&, double,
                               GridView<float>);
template void reconstruct_band(GridView<const std::int32_t>, const KnownBits&, double,
                               GridView<double>);

}  // namespace relief::codec
