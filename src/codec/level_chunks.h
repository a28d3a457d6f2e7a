#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "relief/codec/quantise.h"

/// The chunks that hold quantised bands: one for the scaling band, then one for the details of each
/// level, coarsest first. A chunk is the steps of its bands as float32, then the entropy-coded
/// values.
namespace relief::codec {

/// Number of the chunk a band belongs to: 0 scaling, 1 details of the coarsest level, ...
[[nodiscard]] int chunk_of(const multires::PyramidLayout& layout, const multires::BandLayout& band);

/// Chunk `number`.
[[nodiscard]] std::vector<std::uint8_t> write_level(const multires::PyramidLayout& layout,
                                                    const Quantised& quantised, int number);

/// Reads chunk `number` into `quantised`, whose earlier chunks have been read. Errors: BadFile.
[[nodiscard]] Status read_level(std::span<const std::uint8_t> bytes, int number,
                                const multires::PyramidLayout& layout, Quantised& quantised);

}  // namespace relief::codec
