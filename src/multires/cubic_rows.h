#pragma once

#include <cstdint>

#include "multires/cubic_rules.h"

/// The kernel of scheme `cubic`. Private to the module.
namespace relief::multires::cubic {

/// Where a lifting step reads: tap k weighs the neighbours `lower[k]` and `upper[k]`.
template <class T>
struct Neighbours {
    T weight[kTaps];
    const T* lower[kTaps];
    const T* upper[kTaps];
};

/// out[j] = in[j] + ((w0 (lower0[j] + upper0[j]) + w1 (..)) + ..) for first <= j < last. `out` may
/// be `in`, not a neighbour. Vector kernel with a scalar twin of the same bits.
template <class T>
void lift_row(T* out, const T* in, const Neighbours<T>& neighbours, std::int64_t first,
              std::int64_t last);

}  // namespace relief::multires::cubic
