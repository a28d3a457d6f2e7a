#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "relief/core/grid.h"
#include "relief/core/result.h"

/// A raster in memory: what readers deliver, what the codec keeps, what writers and pictures take.
/// No file format here.
namespace relief {

/// How a file stores one sample.
enum class SampleType : std::uint8_t { UInt8, UInt16, Int16, UInt32, Int32, Float32, Float64 };

/// "uint8", "uint16", "int16", "uint32", "int32", "float32", "float64".
[[nodiscard]] std::string_view sample_type_name(SampleType type);
/// Errors: InvalidArgument listing the names.
[[nodiscard]] Result<SampleType> sample_type_from_name(std::string_view name);
[[nodiscard]] bool is_integer(SampleType type);
/// Smallest and largest finite value of a type.
[[nodiscard]] std::pair<double, double> sample_range(SampleType type);

/// What a file of this type holds for a valid sample: integers are rounded to nearest (ties to
/// even), values are clamped to the type's range, and a value that a reader would take for `nodata`
/// is moved to the neighbour on its own side (integers by one; floats by 8 units of relative
/// precision, because readers compare with a tolerance). Requires: value is finite.
[[nodiscard]] double stored_value(double value, SampleType type, std::optional<double> nodata);

/// out[k] = stored_value(values[k], type, nodata) for k < n; `out` may be `values`. The type is
/// looked at once for all.
void stored_row(const double* values, std::int64_t n, SampleType type, std::optional<double> nodata,
                double* out);

/// Where a raster lies.
struct GeoReference {
    /// x = t[0] + t[1] col + t[2] row, y = t[3] + t[4] col + t[5] row; (col, row) = (0, 0) is the
    /// outer corner of the first sample's cell, its centre is (0.5, 0.5).
    std::optional<std::array<double, 6>> transform = {};
    /// "EPSG:26911", or another authority and code, where these say everything; else WKT2:2019;
    /// empty: unknown. x is always east or longitude.
    std::string crs = {};
    bool pixel_is_point = false;  ///< samples stand for points, not for the mean of a cell

    friend bool operator==(const GeoReference&, const GeoReference&) = default;
};

/// One to four planes of samples on a grid, and what a file says about them.
struct Raster {
    std::int64_t rows = 0;
    std::int64_t cols = 0;
    SampleType type = SampleType::Float32;
    std::vector<Grid<double>> planes = {};  ///< NaN in holes; every sample type is exact in double
    Grid<std::uint8_t> mask = {};           ///< 1 valid, 0 hole; empty: all valid
    std::optional<double> nodata = {};      ///< the value that stands for a hole in the file
    GeoReference geo = {};
    std::string unit = {};  ///< of the samples: "m", "ft"; empty: unknown
    double scale = 1;  ///< physical value = sample x scale + offset: kept for the file, not applied
    double offset = 0;
    std::vector<std::string> band_names = {};  ///< one a plane, or none
    std::vector<std::pair<std::string, std::string>> metadata =
        {};  ///< of the default domain, in order

    [[nodiscard]] bool valid(std::int64_t row, std::int64_t col) const {
        return mask.empty() || mask(row, col) != 0;
    }
    [[nodiscard]] std::int64_t valid_count() const;
};

/// Called with the fraction done, 0 .. 1, from the calling thread; returning false cancels.
using Progress = std::function<bool(double)>;

}  // namespace relief
