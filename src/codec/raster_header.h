#pragma once

#include <cmath>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "codec/tile_codec.h"
#include "relief/codec/raster_codec.h"

namespace relief::codec {

/// How an open-loop file quantises its pyramid and orders what it knows.
struct PyramidCoding {
    double step = 1;  ///< of a coefficient whose basis function has norm 1
    std::vector<int> exponents =
        {};                          ///< if not empty: the step of band k is 2^exponents[k] instead
    std::vector<int> layers = {0};   ///< lowest bit plane of each, descending to 0
    std::vector<double> means = {};  ///< of each component: added to the scaling band
    /// Largest error of the surface that the file gives without details of level k + 1 and finer
    /// ones; infinite: not known.
    std::vector<double> bounds = {};

    [[nodiscard]] double step_of(const multires::PyramidLayout& layout, std::size_t band) const {
        return exponents.empty() ? step / layout.bands[band].norm_samples
                                 : std::ldexp(1.0, exponents[band]);
    }
};

/// What the header of a raster file says, besides the coded data.
struct RasterHeader {
    Raster description;  ///< no planes, no mask
    int components = 1;
    bool has_mask = false;
    multires::SchemeSpec spec;
    Goal goal;
    double max_error = 0;
    double rms_error = 0;
    std::optional<LatticeCoding> lattice = {};  ///< of files of the closed loop
    PyramidCoding pyramid = {};                 ///< of other files

    /// Of the finest lattice.
    [[nodiscard]] std::int64_t lattice_rows() const { return description.rows + margin().rows; }
    [[nodiscard]] std::int64_t lattice_cols() const { return description.cols + margin().cols; }
    [[nodiscard]] LatticeMargin margin() const {
        return lattice ? lattice->margin : LatticeMargin();
    }
};

[[nodiscard]] std::string_view profile_name(Profile profile);
[[nodiscard]] std::string_view goal_name(Goal::Kind kind);

/// Members of headers of all contents. Errors keep four digits, the largest one rounded up.
[[nodiscard]] nlohmann::json goal_json(const Goal& goal);
[[nodiscard]] nlohmann::json error_json(double max, double rms, const Goal& goal);

/// JSON text. Members with their default values are left out.
[[nodiscard]] std::string write_header(const RasterHeader& header);

/// Errors: BadFile naming the member that is missing, of the wrong type or out of range;
/// Unsupported for other contents.
[[nodiscard]] Result<RasterHeader> read_header(const std::string& text);
[[nodiscard]] Result<RasterHeader> read_header(const nlohmann::json& json);

}  // namespace relief::codec
