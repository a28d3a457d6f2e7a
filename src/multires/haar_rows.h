#pragma once

#include <array>
#include <cstdint>

#include "multires/row_copy.h"

/// Row kernels of the barycentric transform whose filters are (w, w) and (w, -w): the three
/// directional passes of one coarse point are a butterfly of eight values, scaled once. They have
/// scalar twins that give the same bytes. Outputs must not overlap inputs. No alignment is
/// required.
namespace relief::multires::barycentric {

/// fine: rows 2i - 1, 2i, 2i + 1, each from column 2j - 1 on (2n + 1 elements are read).
/// channels[c][k] = scale * sum of +- fine(2(i, j + k) + l e1 + m e2 + n e3), l, m, n in {0, 1}:
/// minus where the product of the channel's high letters says so. With Traffic::Streamed all
/// channels but 0 go past the caches.
template <class T>
void haar_analysis_row(T scale, const std::array<const T*, 3>& fine, std::int64_t n,
                       const std::array<T*, 8>& channels, Traffic details);

/// The transpose before its overlaps are added: points[4 l + 2 m + n][k] = scale * sum of +-
/// channels[c][k].
template <class T>
void haar_points_row(T scale, const std::array<const T*, 8>& channels, std::int64_t n,
                     const std::array<T*, 8>& points);

/// out[2k] = even[0][k] + even[1][k], out[2k + 1] = odd[0][k] + odd[1][k] for k < pairs.
template <class T>
void merge_sums_row(const std::array<const T*, 2>& even, const std::array<const T*, 2>& odd,
                    std::int64_t pairs, T* out);

}  // namespace relief::multires::barycentric
