#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "relief/core/raster.h"
#include "relief/core/stream.h"
#include "relief/multires/pyramid.h"

/// The layer that turns a close surface into one within a bound, or into the exact samples.
namespace relief::codec {

/// A sample becomes stored(base + k * step), or, in ordered mode, the float that lies k places
/// above the stored base; base is the surface, for integer types rounded first.
struct Corrections {
    struct Repair {
        std::uint8_t component = 0;
        std::uint64_t index = 0;  ///< row * cols + col
        double value = 0;
    };

    bool ordered = false;
    double step = 1;
    std::vector<Grid<std::int64_t>> planes;  ///< k, for each component
    std::vector<Repair> repairs;             ///< samples that no k brings within the bound
    std::int64_t corrected = 0;              ///< samples with a k that is not zero, or a repair
};

/// Corrections that bring every valid sample of `surface` within `bound` of `original` in its
/// sample type; bound 0: exactly. Verified sample by sample. Complexity: O(samples).
[[nodiscard]] Corrections make_corrections(const Raster& original,
                                           const multires::Planes<double>& surface, double bound);

/// Applies them to a window of the raster: corrected samples take their final value, others keep
/// the unrounded surface.
void apply_corrections(const Corrections& corrections, SampleType type,
                       std::optional<double> nodata, const LatticeBox& window,
                       multires::Planes<double>& surface);

[[nodiscard]] Bytes write_corrections(const Corrections& corrections);

/// Errors: BadFile.
[[nodiscard]] Result<Corrections> read_corrections(std::span<const std::uint8_t> bytes,
                                                   std::int64_t rows, std::int64_t cols,
                                                   int components);

}  // namespace relief::codec
