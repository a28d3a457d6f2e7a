#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "relief/core/raster.h"
#include "relief/core/stream.h"

/// Rasters in and out of every format that GDAL knows, whole or in parts. GDAL's block cache, which
/// all rasters of a process share, is bounded: see docs/rasters.md.
namespace relief::io {

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

/// An open raster that is read window by window, as read_raster reads it. Several threads may read;
/// GDAL serves one of them at a time. Reads go by whole rows of the file's blocks, and the cache
/// holds such a row of all bands (up to 1 GiB): windows from top to bottom decode each block once.
class RasterReader final : public RasterSource {
  public:
    /// Errors: NotFound; BadInput, as read_raster.
    [[nodiscard]] static Result<RasterReader> open(const std::string& path);

    RasterReader(RasterReader&& other) noexcept;
    RasterReader& operator=(RasterReader&&) = delete;
    ~RasterReader() override;

    [[nodiscard]] const Raster& description() const override;
    [[nodiscard]] int components() const override;
    /// The window as a raster of its own: with its description, its transform shifted. The mask is
    /// empty if it has no hole. Complexity: O(samples of the window), 8 bytes a sample of one
    /// plane. Errors: InvalidArgument (window not inside the raster); BadInput (too large for
    /// memory); BadFile (damaged).
    [[nodiscard]] Result<Raster> read(const LatticeBox& window) const override;
    /// The same; false from `progress` cancels. Errors: and Cancelled.
    [[nodiscard]] Result<Raster> read(const LatticeBox& window, const Progress& progress) const;

  private:
    friend Result<RasterReader> reader_of(void* dataset);  // relief/io/gdal.h
    struct File;
    explicit RasterReader(std::unique_ptr<File> file);
    [[nodiscard]] static Result<RasterReader> create(std::unique_ptr<File> file);

    std::unique_ptr<File> file_;
};

struct WriteOptions {
    Progress progress = {};
    std::string driver = {};  ///< GDAL's short name; empty: by the extension, .tif being GTiff
    std::vector<std::string> creation_options = {};  ///< "NAME=VALUE", in place of our defaults
};

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

/// Whether a raster that is written in strips may have holes, which its file must have a code for.
enum class Holes : std::uint8_t { None, Possible };

/// Writes a raster in strips of whole rows, from top to bottom, as write_raster writes it at once.
/// GeoTIFF: in memory that holds one row of the file's blocks and does not grow with the rows. The
/// strips of other formats are collected, 8 bytes a sample, and written on commit().
class RasterWriter {
  public:
    /// A raster of the size and with the description of `description`, whose planes and mask are
    /// not looked at. Holes::Possible: holes become description.nodata if the type holds it, else
    /// NaN (floats) or 0 under a mask band (integers). Errors: InvalidArgument as write_raster,
    /// CannotWrite.
    [[nodiscard]] static Result<RasterWriter> create(const std::string& path,
                                                     const Raster& description, int components,
                                                     Holes holes, const WriteOptions& options = {});

    RasterWriter(RasterWriter&& other) noexcept;
    RasterWriter& operator=(RasterWriter&&) = delete;
    ~RasterWriter();

    /// Takes planes and mask of rows first_row .. first_row + strip.rows - 1. Strips of any height
    /// follow each other without gaps. Errors: InvalidArgument (not the next rows, another number
    /// of planes or columns, a hole that has no code), CannotWrite, Cancelled.
    [[nodiscard]] Status write(std::int64_t first_row, const Raster& strip);
    /// The file appears under its name; without a commit nothing stays. Errors: InvalidArgument
    /// (rows are missing; as write_raster), CannotWrite, Cancelled.
    [[nodiscard]] Status commit();

  private:
    struct State;
    explicit RasterWriter(std::unique_ptr<State> state);

    std::unique_ptr<State> state_;
};

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

/// What a unit of x and one of y are on the ground at the middle row, in the unit of a raster's
/// heights: feet and US survey feet by their names, anything else is taken for metres. 1 without a
/// transform or a CRS. Planes are not read.
[[nodiscard]] CellSize ground_scale(const Raster& about);

/// The size of a cell in the unit of a raster's heights. Nothing without a transform or a CRS.
[[nodiscard]] std::optional<CellSize> cell_size_in_unit(const Raster& about);

}  // namespace relief::io
