#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/ps_header.h"
#include "codec/ps_values.h"
#include "relief/codec/ps_codec.h"

/// What encoder and decoder of files of Powell-Sabin splines share.
namespace relief::codec {

/// The chunks of a file without edits.
struct PsContents {
    Bytes mesh;
    std::vector<Bytes> levels;   ///< from the coarsest
    std::vector<double> bounds;  ///< of the surfaces of the levels
    Bytes correction = {};
};
[[nodiscard]] Result<Bytes> write_ps_file(const PsHeader& header, const PsContents& contents);

/// The spline through values. Errors: those of multires::ps::estimate_gradients.
[[nodiscard]] Result<LevelHeights> splines_through(const multires::ps::Space& space,
                                                   const VertexValues& values,
                                                   const multires::ps::GradientOptions& gradients);

/// On the finest level of the hierarchy, a spline of a coarser one.
[[nodiscard]] multires::ps::Coefficients refined(const multires::ps::Hierarchy& hierarchy,
                                                 int level, multires::ps::Coefficients spline);

[[nodiscard]] Bytes write_ps_moves(const std::vector<PsMove>& moves);
/// Errors: BadFile.
[[nodiscard]] Result<std::vector<PsMove>> read_ps_moves(std::span<const std::uint8_t> bytes);

}  // namespace relief::codec
