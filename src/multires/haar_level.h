#pragma once

#include "multires/barycentric_tiles.h"

/// One level of the barycentric transform for order 1 with dual order 1, whose filters have two
/// taps of one size: analyse_level and synthesise_level as row butterflies. Private to the module.
namespace relief::multires::barycentric {

/// Whether low is (w, w) and high is (w, -w), both from n = 0.
[[nodiscard]] bool is_haar(const Sequence& low, const Sequence& high);

/// analyse_level for Haar filters, `scale` multiplied by their weights. The channels of an m x n
/// box at the origin all have the box of m / 2 + 1 by n / 2 + 1 coefficients at the origin.
template <class T>
void analyse_haar_level(T scale, const RowSource<T>& fine,
                        const std::array<Channel<T>, 8>& channels);

/// synthesise_level for Haar filters, on the same boxes.
template <class T>
void synthesise_haar_level(T scale, const std::array<Channel<const T>, 8>& channels,
                           GridView<T> fine);

}  // namespace relief::multires::barycentric
