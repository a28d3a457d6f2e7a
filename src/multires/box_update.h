#pragma once

#include <array>
#include <cstdint>

#include "multires/box_rules.h"

namespace relief::multires::box {

/// Rows of edge coefficients around vertex row y that its update reads: kind k, row y + offset,
/// offset -2 .. 2.
inline constexpr int kUpdateRows = kEdgeKinds * (2 * kUpdateReach + 1);
constexpr int update_row_slot(int kind, int row_offset) {
    return kind * (2 * kUpdateReach + 1) + row_offset + kUpdateReach;
}

/// Elements that may be read in front of and behind each row of `edges`; those within kUpdateReach
/// of the row count as coefficients (zero where there is no edge), the others are read and not
/// used.
inline constexpr std::int64_t kRowMargin = 32;

/// Four rows of n elements that will be read soon: the update computes long enough on what it has
/// loaded to fetch them.
template <class T>
using SoonRows = std::array<const T*, 4>;

/// out[j] = vertices[j] + sign * sum of the update's 42 (order 1: 12) weighted edge coefficients,
/// for j < n. Taps of one column shift are added up first, weight by weight; then the five shifted
/// sums. `out` may be `vertices`.
template <class T>
void update_vertices(int order, T sign, const std::array<const T*, kUpdateRows>& edges,
                     const T* vertices, std::int64_t n, const SoonRows<T>& soon, T* out);

}  // namespace relief::multires::box
