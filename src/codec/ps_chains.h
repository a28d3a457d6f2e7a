#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/ps_place_set.h"

/// Places along lines: scanners and ships measure one point after another. docs/format.md,
/// "Places".
namespace relief::codec {

/// Some places in an order in which each lies near where the two before it lead, with the others.
struct PlaceChains {
    std::vector<GridPlace> chained;
    std::vector<std::uint8_t> begins;  ///< of each chained place: a new chain begins there
    std::vector<GridPlace> rest;
};

/// Chains of six places or more that leave their directions by little for so many places on so
/// much area. Complexity: O(n) for places that are spread evenly.
[[nodiscard]] PlaceChains find_chains(std::vector<GridPlace> places);

[[nodiscard]] Bytes write_chains(const PlaceChains& chains);
/// Errors: BadFile.
[[nodiscard]] Result<std::vector<GridPlace>> read_chains(std::span<const std::uint8_t> bytes,
                                                         std::uint64_t count);

}  // namespace relief::codec
