#pragma once

#include <cpl_string.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/gdal_scope.h"
#include "relief/io/file.h"
#include "relief/io/raster.h"

/// What writers of whole rasters and of strips share.
namespace relief::io::detail {

/// How holes are marked in the file.
struct HoleCode {
    std::optional<double> nodata = {};
    bool mask_band = false;
};

/// A sample that is masked or not finite in one of the planes.
[[nodiscard]] bool is_hole(const Raster& raster, std::int64_t row, std::int64_t col);
/// The first row with a hole, from the top.
[[nodiscard]] std::optional<std::int64_t> row_with_hole(const Raster& raster);

/// Errors: InvalidArgument (sizes, number of planes or names).
[[nodiscard]] Status check_description(const Raster& description, std::size_t planes,
                                       const std::string& path);
/// Errors: InvalidArgument (planes or mask of another size).
[[nodiscard]] Status check_samples(const Raster& raster, const std::string& path);

/// The driver that the options name, or the first, in GDAL's order, that writes files with this
/// extension. Errors: InvalidArgument (no such driver, syntax of an option).
[[nodiscard]] Result<GDALDriverH> choose_driver(const std::string& path,
                                                const WriteOptions& options);
[[nodiscard]] bool is_geotiff(GDALDriverH driver);

/// Whether nodata of this value is possible.
[[nodiscard]] bool in_type(double value, SampleType type);

/// Georeference, metadata, names, unit and nodata. False: GDAL failed.
[[nodiscard]] bool describe(GDALDatasetH dataset, const Raster& description, std::size_t planes,
                            const HoleCode& code);

/// The creation options of the caller, over `list`.
void add_creation_options(const WriteOptions& options, CPLStringList& list);

[[nodiscard]] Error cannot_write_as(GDALDriverH driver, const GdalScope& gdal,
                                    const std::string& path);

/// Where GDAL makes a file: in a staging directory, or at once in a virtual file system. Without a
/// commit nothing stays.
class Destination {
  public:
    /// Errors: as StagedOutput::beside.
    [[nodiscard]] static Result<Destination> at(const std::string& path);

    Destination(Destination&& other) noexcept;
    Destination& operator=(Destination&&) = delete;
    ~Destination();

    /// The name for GDAL.
    [[nodiscard]] const std::string& name() const {
        return staged_ ? staged_->temporary_path() : path_;
    }
    /// The file appears; what described the file it replaces goes. Requires: GDAL has closed it.
    /// Errors: CannotWrite.
    [[nodiscard]] Status commit();

  private:
    Destination(std::string path, std::optional<StagedOutput> staged);

    std::string path_;  ///< empty once moved from or committed
    std::optional<StagedOutput> staged_;
};

/// Hands rows to a dataset, from top to bottom, as whole blocks and past GDAL's cache: each block
/// is written once, in the same order whatever else goes on. Holds one row of blocks.
class BlockWriter {
  public:
    /// For all bands of the dataset, and its mask band if that takes the holes.
    BlockWriter(GDALDatasetH dataset, SampleType type, const HoleCode& code);

    /// Appends rows first .. first + count - 1 of `raster`. False: GDAL failed.
    [[nodiscard]] bool write(const Raster& raster, std::int64_t first, std::int64_t count);

  private:
    struct Band {
        GDALRasterBandH handle;
        GDALDataType type;
        std::vector<std::uint8_t> blocks;  ///< one row of them, each a row-major array
    };

    void store(const Raster& raster, std::int64_t raster_row, std::int64_t block_row);
    void store(const std::vector<double>& values, std::int64_t block_row, Band& band) const;
    bool flush();

    SampleType type_;
    HoleCode code_;
    std::vector<Band> bands_;  ///< of the planes, then the mask
    std::int64_t rows_;
    int block_cols_ = 1;
    int block_rows_ = 1;
    int across_;             ///< blocks beside each other
    std::int64_t next_ = 0;  ///< rows taken so far
};

/// A GeoTIFF written from top to bottom in memory that does not grow with its rows.
class TiffOutput {
  public:
    /// Errors: CannotWrite.
    [[nodiscard]] static Result<TiffOutput> create(const std::string& path,
                                                   const Raster& description, std::size_t planes,
                                                   const HoleCode& code,
                                                   const WriteOptions& options);

    TiffOutput(TiffOutput&&) noexcept = default;
    TiffOutput& operator=(TiffOutput&&) = delete;
    ~TiffOutput();

    /// Appends rows first .. first + count - 1 of `raster`. Errors: CannotWrite.
    [[nodiscard]] Status write(const Raster& raster, std::int64_t first, std::int64_t count);
    /// Requires: all rows are written. Errors: CannotWrite.
    [[nodiscard]] Status commit();

  private:
    TiffOutput(std::string path, Destination destination, Dataset dataset, BlockWriter blocks);

    std::string path_;
    Destination destination_;
    Dataset dataset_;  ///< is closed before the destination goes
    BlockWriter blocks_;
};

}  // namespace relief::io::detail
