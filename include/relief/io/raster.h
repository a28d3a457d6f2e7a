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

/// Rasters in and out of every format that GDAL knows. See docs/rasters.md.
namespace relief::io {

/// How a file stores one sample.
enum class SampleType : std::uint8_t { UInt8, UInt16, Int16, UInt32, Int32, Float32, Float64 };

/// "uint8", "uint16", "int16", "uint32", "int32", "float32", "float64".
[[nodiscard]] std::string_view sample_type_name(SampleType type);
/// Errors: InvalidArgument listing the names.
[[nodiscard]] Result<SampleType> sample_type_from_name(std::string_view name);
[[nodiscard]] bool is_integer(SampleType type);
/// Smallest and largest finite value of a type.
[[nodiscard]] std::pair<double, double> sample_range(SampleType type);

/// Where a raster lies.
struct GeoReference {
    /// x = t[0] + t[1] col + t[2] row, y = t[3] + t[4] col + t[5] row; (col, row) = (0, 0) is the
    /// outer corner of the first sample's cell, its centre is (0.5, 0.5).
    std::optional<std::array<double, 6>> transform;
    std::string crs_wkt;          ///< WKT2:2019; empty: unknown. x is always east or longitude.
    bool pixel_is_point = false;  ///< samples stand for points, not for the mean of a cell

    friend bool operator==(const GeoReference&, const GeoReference&) = default;
};

/// One to four planes of samples on a grid, and what a file says about them.
struct Raster {
    std::int64_t rows = 0;
    std::int64_t cols = 0;
    SampleType type = SampleType::Float32;
    std::vector<Grid<double>> planes;  ///< NaN in holes; every sample type is exact in double
    Grid<std::uint8_t> mask;           ///< 1 valid, 0 hole; empty: all valid
    std::optional<double> nodata;      ///< the value that stands for a hole in the file
    GeoReference geo;
    std::string unit;  ///< of the samples: "m", "ft"; empty: unknown
    double scale = 1;  ///< physical value = sample x scale + offset: kept for the file, not applied
    double offset = 0;
    std::vector<std::string> band_names;                        ///< one a plane, or none
    std::vector<std::pair<std::string, std::string>> metadata;  ///< of the default domain, in order

    [[nodiscard]] bool valid(std::int64_t row, std::int64_t col) const {
        return mask.empty() || mask(row, col) != 0;
    }
};

/// Called with the fraction done, 0 .. 1, from the calling thread; returning false cancels.
using Progress = std::function<bool(double)>;

struct ReadOptions {
    Progress progress = {};
    std::optional<LatticeBox> window =
        {};  ///< only these samples; the transform is shifted accordingly
};

/// Reads all bands. A hole in one band (nodata value, mask, transparent alpha, NaN or infinity) is
/// a hole in all; an alpha band becomes the mask. Signed bytes become int16; bands of different
/// types the narrowest type that holds them all. Nothing is written beside the input. `path` is
/// anything GDAL opens, /vsizip/ and the like too. Complexity: O(samples), 8 bytes a sample of one
/// plane. Errors: NotFound; BadInput (not a raster, no band, more than 4, complex or 64-bit integer
/// samples, only subdatasets); InvalidArgument (window not inside the raster); BadFile (damaged);
/// Cancelled.
[[nodiscard]] Result<Raster> read_raster(const std::string& path, const ReadOptions& options = {});

struct WriteOptions {
    Progress progress = {};
    std::string driver = {};  ///< GDAL's short name; empty: by the extension, .tif being GTiff
    std::vector<std::string> creation_options = {};  ///< "NAME=VALUE", in place of our defaults
};

/// What write_raster stores for a valid sample: integers are rounded to nearest (ties to even),
/// values are clamped to the type's range, and a value that a reader would take for `nodata` is
/// moved off it on its own side: integers by one, floats by 2^-20 of nodata, because readers
/// compare floats with a tolerance of nearly that. Requires: value is finite; nodata is a value of
/// the type.
[[nodiscard]] double stored_value(double value, SampleType type, std::optional<double> nodata);

/// Writes a raster; it appears under its name, with its side files, only when complete. Samples are
/// stored as raster.type; a format that lacks the type gets the narrowest one that holds every
/// value exactly (.png: uint16). Samples that are not finite are holes. Holes are written as
/// raster.nodata if the type holds it, else as NaN (floats) or as a value that no sample has
/// (integers), else through a mask band (GeoTIFF). GeoTIFF defaults: DEFLATE, predictor, tiles,
/// BigTIFF when needed. Same bytes for any thread count. Errors: InvalidArgument (planes of
/// different sizes, unknown extension, driver or creation option syntax, format without write
/// support or without a fitting type), CannotWrite, Cancelled.
[[nodiscard]] Status write_raster(const std::string& path, const Raster& raster,
                                  const WriteOptions& options = {});

/// The size of a cell in metres.
struct CellSize {
    double x = 1;  ///< along a row
    double y = 1;  ///< along a column

    friend bool operator==(const CellSize&, const CellSize&) = default;
};

/// Cell size at the middle row. Degrees are measured on the WGS 84 ellipsoid, other linear units
/// converted; without a transform 1 x 1, with an unknown CRS the transform's numbers are taken for
/// metres.
[[nodiscard]] CellSize cell_size_metres(const GeoReference& geo, std::int64_t rows);

}  // namespace relief::io
