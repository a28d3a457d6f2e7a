#pragma once

#include <cstdint>

/// Row kernels of derivative estimation. Private to the module.
namespace relief::spline {

template <class T>
struct RowDifference {
    const T* plus;
    const T* minus;
    T weight;
};

/// out[k] = scale * ((w0 (p0[k] - m0[k]) + w1 (p1[k] - m1[k])) + ..). Differences first: constants
/// give exactly zero. Zero if count is zero. `out` must not overlap an input.
template <class T>
void row_differences(T* out, std::int64_t n, T scale, const RowDifference<T>* terms, int count);

}  // namespace relief::spline
