#pragma once

#include <cstdint>

/// Element-wise kernels on rows of float or double, the building blocks of every raster transform.
/// Each has a vector version chosen at run time and a scalar twin (relief/core/simd.h); both
/// evaluate the same expression in the same order without fused multiply-add, so results agree to
/// the bit on every machine. No alignment is required. `out` must not overlap an input unless
/// stated.
namespace relief {

template <class T>
struct RowTap {
    const T* row;
    T weight;
};

/// out[k] = (((t0 + t1) + t2) + ...), t = weight * row[k]; a weight of exactly 1 or -1 is still one
/// multiplication. `out` may be one of the rows. Requires count >= 1. Complexity: O(n * count), one
/// pass.
template <class T>
void row_fir(T* out, std::int64_t n, const RowTap<T>* taps, int count);

/// out[k] = out[k] + t0 + t1 + ... in this order.
template <class T>
void row_fir_add(T* out, std::int64_t n, const RowTap<T>* taps, int count);

/// even[k] = src[2k], odd[k] = src[2k + 1] for k < pairs.
template <class T>
void row_split(const T* src, std::int64_t pairs, T* even, T* odd);

/// dst[2k] = even[k], dst[2k + 1] = odd[k] for k < pairs.
template <class T>
void row_merge(const T* even, const T* odd, std::int64_t pairs, T* dst);

/// sum[k] = a[k] + b[k], difference[k] = a[k] - b[k]. The outputs may be the inputs.
template <class T>
void row_butterfly(const T* a, const T* b, std::int64_t n, T* sum, T* difference);

}  // namespace relief
