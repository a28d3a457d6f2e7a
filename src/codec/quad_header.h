#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "codec/value_lattice.h"
#include "relief/codec/raster_codec.h"
#include "relief/core/result.h"

namespace relief::codec {

/// The content of files of this kind.
inline constexpr const char* kQuadContent = "quadrangulation";

/// What the header of a file of a quadrangulation says.
struct QuadHeader {
    std::uint64_t vertices = 0;  ///< of the base mesh
    std::uint64_t quads = 0;     ///< of the base mesh
    int levels = 0;
    std::optional<int> x_digits;  ///< after the point, of all coordinates
    std::optional<int> y_digits;
    /// Of which all values are members; none: the file has coefficients instead of values.
    std::optional<ValueLattice> lattice;
    Goal goal;
    double max_error = 0;      ///< of the values at the vertices
    double rms_error = 0;      ///< of the same
    double surface_error = 0;  ///< certified bound of the surface's error
};

/// JSON text. Members with their default values are left out.
[[nodiscard]] std::string write_quad_header(const QuadHeader& header);

/// Errors: BadFile naming the member that is missing, of the wrong type or out of range;
/// Unsupported for other contents.
[[nodiscard]] Result<QuadHeader> read_quad_header(const std::string& text);

}  // namespace relief::codec
