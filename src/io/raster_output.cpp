#include "io/raster_output.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "io/spatial_reference.h"
#include "relief/core/parallel.h"

namespace relief::io::detail {

namespace {

bool can_write(GDALDriverH driver) {
    const auto has = [&](const char* capability) {
        return GDALGetMetadataItem(driver, capability, nullptr) != nullptr;
    };
    return has(GDAL_DCAP_RASTER) && (has(GDAL_DCAP_CREATE) || has(GDAL_DCAP_CREATECOPY)) &&
           !EQUAL(GDALGetDriverShortName(driver), "VRT");
}

GDALDriverH driver_for_extension(const std::string& extension) {
    for (int k = 0; k < GDALGetDriverCount(); ++k) {
        GDALDriverH driver = GDALGetDriver(k);
        const char* extensions = GDALGetMetadataItem(driver, GDAL_DMD_EXTENSIONS, nullptr);
        if (!extensions || !can_write(driver)) continue;
        const CPLStringList list(CSLTokenizeString(extensions));
        if (list.FindString(extension.c_str()) >= 0) return driver;
    }
    return nullptr;
}

/// Statistics, overviews and masks of the file to be replaced that the new one does not bring
/// itself.
std::vector<std::string> stale_side_files(const std::string& path, const std::string& staged) {
    std::vector<std::string> stale;
    for (const char* suffix : {".aux.xml", ".ovr", ".msk"}) {
        std::error_code error;
        if (!std::filesystem::exists(staged + suffix, error)) stale.push_back(path + suffix);
    }
    return stale;
}

CPLStringList geotiff_options(const Raster& description, const WriteOptions& options) {
    CPLStringList list;
    list.SetNameValue("COMPRESS", "DEFLATE");
    list.SetNameValue("PREDICTOR", is_integer(description.type) ? "2" : "3");
    list.SetNameValue("INTERLEAVE", "BAND");
    list.SetNameValue("PHOTOMETRIC", "MINISBLACK");  // four bytes are no picture with transparency
    list.SetNameValue("BIGTIFF", "IF_SAFER");
    list.SetNameValue("NUM_THREADS", std::to_string(thread_count()).c_str());
    if (std::min(description.rows, description.cols) >= 256) list.SetNameValue("TILED", "YES");
    add_creation_options(options, list);
    return list;
}

/// A thread-local GDAL setting for the life time of this object.
class LocalSetting {
  public:
    LocalSetting(const char* name, const char* value) : name_(name) {
        CPLSetThreadLocalConfigOption(name, value);
    }
    LocalSetting(const LocalSetting&) = delete;
    LocalSetting& operator=(const LocalSetting&) = delete;
    ~LocalSetting() { CPLSetThreadLocalConfigOption(name_, nullptr); }

  private:
    const char* name_;
};

}  // namespace

bool is_hole(const Raster& raster, std::int64_t row, std::int64_t col) {
    return !raster.valid(row, col) ||
           std::any_of(raster.planes.begin(), raster.planes.end(),
                       [&](const auto& plane) { return !std::isfinite(plane(row, col)); });
}

std::optional<std::int64_t> row_with_hole(const Raster& raster) {
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            if (is_hole(raster, r, c)) return r;
    return {};
}

Status check_description(const Raster& description, std::size_t planes, const std::string& path) {
    const auto wrong = [&](const char* message) {
        return Error{ErrorCode::InvalidArgument, message, path};
    };
    constexpr std::int64_t most = std::numeric_limits<int>::max();
    if (description.rows < 1 || description.cols < 1)
        return wrong("a raster without samples can not be written");
    if (description.rows > most || description.cols > most)
        return wrong("more than 2^31 - 1 samples a side; write parts");
    if (planes < 1 || planes > 4) return wrong("a raster has 1 to 4 planes");
    if (!description.band_names.empty() && description.band_names.size() != planes)
        return wrong("give one band name a plane, or none");
    return {};
}

Status check_samples(const Raster& raster, const std::string& path) {
    const auto wrong = [&](const char* message) {
        return Error{ErrorCode::InvalidArgument, message, path};
    };
    const auto fits = [&](const auto& grid) {
        return grid.rows() == raster.rows && grid.cols() == raster.cols;
    };
    if (!std::all_of(raster.planes.begin(), raster.planes.end(), fits))
        return wrong("the planes have another size than the raster");
    if (!raster.mask.empty() && !fits(raster.mask))
        return wrong("the mask has another size than the raster");
    return {};
}

Result<GDALDriverH> choose_driver(const std::string& path, const WriteOptions& options) {
    const auto wrong = [&](std::string message) {
        return Error{ErrorCode::InvalidArgument, std::move(message), path};
    };
    for (const std::string& option : options.creation_options)
        if (option.find('=') == std::string::npos)
            return wrong(fmt::format("the creation option '{}' is not NAME=VALUE", option));
    if (!options.driver.empty()) {
        GDALDriverH driver = GDALGetDriverByName(options.driver.c_str());
        if (driver && can_write(driver)) return driver;
        return wrong(fmt::format(
            "GDAL has no driver '{}' that writes samples; see gdalinfo --formats", options.driver));
    }
    std::string extension = std::filesystem::path(path).extension().string();
    if (!extension.empty()) extension.erase(0, 1);
    if (GDALDriverH driver = extension.empty() ? nullptr : driver_for_extension(extension))
        return driver;
    return wrong(fmt::format(
        "no raster format is written with the extension '{}'; use .tif, or name a driver",
        extension));
}

bool is_geotiff(GDALDriverH driver) {
    return EQUAL(GDALGetDriverShortName(driver), "GTiff");
}

bool in_type(double value, SampleType type) {
    const auto [low, high] = sample_range(type);
    if (is_integer(type)) return value >= low && value <= high && value == std::nearbyint(value);
    return std::isnan(value) || (value >= low && value <= high);
}

bool describe(GDALDatasetH dataset, const Raster& description, std::size_t planes,
              const HoleCode& code) {
    const GeoReference& geo = description.geo;
    std::array<double, 6> transform = geo.transform.value_or(std::array<double, 6>{});
    if (geo.transform && GDALSetGeoTransform(dataset, transform.data()) != CE_None) return false;
    if (!geo.crs.empty()) {
        const SpatialReference crs = reference_of(geo.crs);
        if (!crs || GDALSetSpatialRef(dataset, crs.get()) != CE_None) return false;
    }
    for (const auto& [name, value] : description.metadata)
        GDALSetMetadataItem(dataset, name.c_str(), value.c_str(), nullptr);
    if (geo.pixel_is_point) GDALSetMetadataItem(dataset, "AREA_OR_POINT", "Point", nullptr);
    for (std::size_t k = 0; k < planes; ++k) {
        GDALRasterBandH band = GDALGetRasterBand(dataset, static_cast<int>(k) + 1);
        if (code.nodata) GDALSetRasterNoDataValue(band, *code.nodata);
        if (!description.unit.empty()) GDALSetRasterUnitType(band, description.unit.c_str());
        if (description.scale != 1 || description.offset != 0) {
            GDALSetRasterScale(band, description.scale);
            GDALSetRasterOffset(band, description.offset);
        }
        if (!description.band_names.empty())
            GDALSetDescription(band, description.band_names[k].c_str());
    }
    return true;
}

void add_creation_options(const WriteOptions& options, CPLStringList& list) {
    for (const std::string& option : options.creation_options) {
        const std::size_t equals = option.find('=');
        list.SetNameValue(option.substr(0, equals).c_str(), option.substr(equals + 1).c_str());
    }
}

Error cannot_write_as(GDALDriverH driver, const GdalScope& gdal, const std::string& path) {
    return {ErrorCode::CannotWrite,
            fmt::format("can not write as {}{}; check the free space and the options",
                        GDALGetDriverShortName(driver), gdal.because()),
            path};
}

Destination::Destination(std::string path, std::optional<StagedOutput> staged)
    : path_(std::move(path)), staged_(std::move(staged)) {}

Destination::Destination(Destination&& other) noexcept
    : path_(std::exchange(other.path_, {})), staged_(std::move(other.staged_)) {}

Destination::~Destination() {
    if (!path_.empty() && !staged_) VSIUnlink(path_.c_str());
}

Result<Destination> Destination::at(const std::string& path) {
    if (is_virtual_path(path)) return Destination(path, {});
    RELIEF_TRY(StagedOutput staged, StagedOutput::beside(path));
    return Destination(path, std::move(staged));
}

Status Destination::commit() {
    const std::string path = std::exchange(path_, {});
    if (!staged_) return {};
    const std::vector<std::string> stale = stale_side_files(path, staged_->temporary_path());
    RELIEF_CHECK(staged_->commit());
    for (const std::string& file : stale) {
        std::error_code error;
        std::filesystem::remove(file, error);
    }
    return {};
}

BlockWriter::BlockWriter(GDALDatasetH dataset, SampleType type, const HoleCode& code)
    : type_(type), code_(code), rows_(GDALGetRasterYSize(dataset)) {
    GDALGetBlockSize(GDALGetRasterBand(dataset, 1), &block_cols_, &block_rows_);
    across_ = (GDALGetRasterXSize(dataset) - 1) / block_cols_ + 1;
    const auto add = [&](GDALRasterBandH handle, GDALDataType sample) {
        const std::int64_t bytes =
            std::int64_t{across_} * block_cols_ * block_rows_ * GDALGetDataTypeSizeBytes(sample);
        bands_.push_back({handle, sample, std::vector<std::uint8_t>(std::size_t(bytes))});
    };
    for (int k = 1; k <= GDALGetRasterCount(dataset); ++k)
        add(GDALGetRasterBand(dataset, k), gdal_type(type));
    // GDAL gives the mask of a GeoTIFF the blocks of its bands.
    if (code.mask_band) add(GDALGetMaskBand(GDALGetRasterBand(dataset, 1)), GDT_Byte);
}

bool BlockWriter::write(const Raster& raster, std::int64_t first, std::int64_t count) {
    for (std::int64_t done = 0; done < count;) {
        const std::int64_t block_row = next_ % block_rows_;
        const std::int64_t some = std::min(count - done, block_rows_ - block_row);
        parallel_for(0, some, 16, [&](std::int64_t from, std::int64_t to) {
            for (std::int64_t r = from; r < to; ++r) store(raster, first + done + r, block_row + r);
        });
        done += some;
        next_ += some;
        if ((next_ % block_rows_ == 0 || next_ == rows_) && !flush()) return false;
    }
    return true;
}

void BlockWriter::store(const Raster& raster, std::int64_t raster_row, std::int64_t block_row) {
    const auto cols = static_cast<std::size_t>(raster.cols);
    std::vector<std::uint8_t> hole(cols);
    for (std::size_t c = 0; c < cols; ++c)
        hole[c] = is_hole(raster, raster_row, static_cast<std::int64_t>(c)) ? 1 : 0;
    std::vector<double> values(cols);
    for (std::size_t k = 0; k < raster.planes.size(); ++k) {
        const double* samples = raster.planes[k].row(raster_row);
        for (std::size_t c = 0; c < cols; ++c) values[c] = hole[c] ? 0 : samples[c];
        stored_row(values.data(), raster.cols, type_, code_.nodata, values.data());
        for (std::size_t c = 0; c < cols; ++c)
            if (hole[c]) values[c] = code_.nodata.value_or(0);
        store(values, block_row, bands_[k]);
    }
    if (!code_.mask_band) return;
    for (std::size_t c = 0; c < cols; ++c) values[c] = hole[c] ? 0 : 255;
    store(values, block_row, bands_.back());
}

void BlockWriter::store(const std::vector<double>& values, std::int64_t block_row,
                        Band& band) const {
    const int size = GDALGetDataTypeSizeBytes(band.type);
    const auto cols = static_cast<std::int64_t>(values.size());
    for (std::int64_t col = 0; col < cols; col += block_cols_) {
        const std::int64_t place = (col * block_rows_ + block_row * block_cols_) * size;
        GDALCopyWords64(values.data() + col, GDT_Float64, sizeof(double),
                        band.blocks.data() + place, band.type, size,
                        std::min<std::int64_t>(block_cols_, cols - col));
    }
}

bool BlockWriter::flush() {
    const auto row = static_cast<int>((next_ - 1) / block_rows_);
    for (int k = 0; k < across_; ++k) {
        for (Band& band : bands_) {
            const std::size_t bytes = band.blocks.size() / static_cast<std::size_t>(across_);
            std::uint8_t* block = band.blocks.data() + static_cast<std::size_t>(k) * bytes;
            if (GDALWriteBlock(band.handle, k, row, block) != CE_None) return false;
        }
    }
    // What the last blocks have beyond the raster is then 0.
    for (Band& band : bands_) std::fill(band.blocks.begin(), band.blocks.end(), 0);
    return true;
}

TiffOutput::TiffOutput(std::string path, Destination destination, Dataset dataset,
                       BlockWriter blocks)
    : path_(std::move(path)),
      destination_(std::move(destination)),
      dataset_(std::move(dataset)),
      blocks_(std::move(blocks)) {}

TiffOutput::~TiffOutput() {
    const GdalScope quiet;
    dataset_.reset();
}

Result<TiffOutput> TiffOutput::create(const std::string& path, const Raster& description,
                                      std::size_t planes, const HoleCode& code,
                                      const WriteOptions& options) {
    const GdalScope gdal;
    const LocalSetting mask_inside("GDAL_TIFF_INTERNAL_MASK", "YES");
    RELIEF_TRY(Destination destination, Destination::at(path));
    GDALDriverH driver = GDALGetDriverByName("GTiff");
    const CPLStringList list = geotiff_options(description, options);
    Dataset dataset(GDALCreate(driver, destination.name().c_str(),
                               static_cast<int>(description.cols),
                               static_cast<int>(description.rows), static_cast<int>(planes),
                               gdal_type(description.type), list.List()));
    if (!dataset || !describe(dataset.get(), description, planes, code) ||
        (code.mask_band && GDALCreateDatasetMaskBand(dataset.get(), GMF_PER_DATASET) != CE_None))
        return cannot_write_as(driver, gdal, path);
    BlockWriter blocks(dataset.get(), description.type, code);
    return TiffOutput(path, std::move(destination), std::move(dataset), std::move(blocks));
}

Status TiffOutput::write(const Raster& raster, std::int64_t first, std::int64_t count) {
    const GdalScope gdal;
    if (blocks_.write(raster, first, count) && !gdal.failed()) return {};
    return cannot_write_as(GDALGetDatasetDriver(dataset_.get()), gdal, path_);
}

Status TiffOutput::commit() {
    const GdalScope gdal;
    GDALDriverH driver = GDALGetDatasetDriver(dataset_.get());
    dataset_.reset();  // the last bytes are written here; whether that went well is in the messages
    if (gdal.failed()) return cannot_write_as(driver, gdal, path_);
    return destination_.commit();
}

}  // namespace relief::io::detail
