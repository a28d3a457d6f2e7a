#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "relief/core/raster.h"
#include "relief/core/result.h"

/// What all codecs of the comparison are given, and what they give back.
namespace relief::peers {

/// Samples row by row without gaps, in the type of the file.
using Values = std::variant<std::vector<std::int16_t>, std::vector<float>>;
/// What a decoder hands out.
using Decoded = std::variant<std::vector<std::int16_t>, std::vector<float>, Raster>;

/// One plane of samples as everybody wants it.
struct Field {
    Raster raster;                    ///< for relief
    Values values;                    ///< for the others; holes are filled smoothly
    std::vector<std::uint8_t> valid;  ///< 1 or 0 a sample; empty: all valid
    std::int64_t valid_count = 0;
    double lowest = 0;  ///< of all values
    double highest = 0;
    std::uint64_t mask_bytes = 0;  ///< what the mask costs a codec that has none of its own

    [[nodiscard]] bool integer() const { return values.index() == 0; }
    [[nodiscard]] std::size_t rows() const { return static_cast<std::size_t>(raster.rows); }
    [[nodiscard]] std::size_t cols() const { return static_cast<std::size_t>(raster.cols); }
    [[nodiscard]] std::size_t count() const { return rows() * cols(); }
};

/// Reads a raster. Errors: those of io::read_raster; Unsupported for more than one plane and for
/// samples that neither int16 nor float32 holds.
[[nodiscard]] Result<Field> read_field(const std::string& path);

/// How far a decoded field is off.
struct Deviation {
    double max_error = 0;
    double rms_error = 0;
    std::int64_t over = 0;  ///< samples that are off by more than the bound
};
/// Over valid samples. Errors: BadInput when the decoded field has another size.
[[nodiscard]] Result<Deviation> deviation(const Field& field, const Decoded& decoded, double bound);

}  // namespace relief::peers
