#pragma once

#include "codec/lattice_assembly.h"
#include "codec/raster_header.h"
#include "relief/codec/raster_codec.h"

/// What encoding a raster at once and in shards have in common.
namespace relief::codec {

/// Errors: InvalidArgument for the goal; BadInput for a raster that is empty or too large.
[[nodiscard]] Status check_raster(const RasterSource& source, const Goal& goal);

/// The goal is a bound of every sample's error.
[[nodiscard]] bool is_bound(const Goal& goal);

/// The largest error of a sample that a goal allows the closed loop; 0: none.
[[nodiscard]] inline double bound_of(const Goal& goal) {
    return goal.kind == Goal::Kind::MaxError ? goal.value : 0;
}

/// The header of a closed-loop file of a raster, its errors left out.
[[nodiscard]] RasterHeader lattice_header(const RasterSource& raster, const Goal& goal,
                                          LatticeCoding coding, bool has_holes);
/// Puts in what was found of the errors at all valid samples.
void set_errors(RasterHeader& header, const LatticeEncoding& encoding);

}  // namespace relief::codec
