#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "io/gdal_scope.h"
#include "relief/core/parallel.h"
#include "relief/io/file.h"

namespace relief::io {

namespace {

using detail::Dataset;
using detail::GdalScope;

/// How holes are marked in the file.
struct HoleCode {
    std::optional<double> nodata;
    bool mask_band = false;
};

bool is_hole(const Raster& raster, std::int64_t row, std::int64_t col) {
    return !raster.valid(row, col) ||
           std::any_of(raster.planes.begin(), raster.planes.end(),
                       [&](const auto& plane) { return !std::isfinite(plane(row, col)); });
}

/// Calls visit(row, col) for every sample that is not a hole, until it returns false.
template <class Visit>
bool all_valid(const Raster& raster, Visit visit) {
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            if (!is_hole(raster, r, c) && !visit(r, c)) return false;
    return true;
}

bool has_holes(const Raster& raster) {
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            if (is_hole(raster, r, c)) return true;
    return false;
}

Status check(const Raster& raster, const std::string& path) {
    const auto wrong = [&](const char* message) {
        return Error{ErrorCode::InvalidArgument, message, path};
    };
    constexpr std::int64_t most = std::numeric_limits<int>::max();
    if (raster.rows < 1 || raster.cols < 1)
        return wrong("a raster without samples can not be written");
    if (raster.rows > most || raster.cols > most)
        return wrong("more than 2^31 - 1 samples a side; write parts");
    if (raster.planes.empty() || raster.planes.size() > 4)
        return wrong("a raster has 1 to 4 planes");
    const auto fits = [&](const auto& grid) {
        return grid.rows() == raster.rows && grid.cols() == raster.cols;
    };
    if (!std::all_of(raster.planes.begin(), raster.planes.end(), fits))
        return wrong("the planes have another size than the raster");
    if (!raster.mask.empty() && !fits(raster.mask))
        return wrong("the mask has another size than the raster");
    if (!raster.band_names.empty() && raster.band_names.size() != raster.planes.size())
        return wrong("give one band name a plane, or none");
    return {};
}

bool can_write(GDALDriverH driver) {
    const auto has = [&](const char* capability) {
        return GDALGetMetadataItem(driver, capability, nullptr) != nullptr;
    };
    return has(GDAL_DCAP_RASTER) && (has(GDAL_DCAP_CREATE) || has(GDAL_DCAP_CREATECOPY)) &&
           !EQUAL(GDALGetDriverShortName(driver), "VRT");
}

/// The first driver, in GDAL's order, that writes files with this extension.
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

Status check_options(const WriteOptions& options, const std::string& path) {
    for (const std::string& option : options.creation_options)
        if (option.find('=') == std::string::npos)
            return Error{ErrorCode::InvalidArgument,
                         fmt::format("the creation option '{}' is not NAME=VALUE", option), path};
    return {};
}

Result<GDALDriverH> choose_driver(const std::string& path, const WriteOptions& options) {
    const auto wrong = [&](std::string message) {
        return Error{ErrorCode::InvalidArgument, std::move(message), path};
    };
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

/// Whether every value survives as `type`.
bool holds(const Raster& raster, SampleType type) {
    return all_valid(raster, [&](std::int64_t r, std::int64_t c) {
        return std::all_of(raster.planes.begin(), raster.planes.end(), [&](const auto& plane) {
            const double value = stored_value(plane(r, c), raster.type, {});
            return stored_value(value, type, {}) == value;
        });
    });
}

/// raster.type, or the narrowest exact substitute if the format has no such samples.
Result<SampleType> choose_type(const Raster& raster, GDALDriverH driver, const std::string& path) {
    const char* names = GDALGetMetadataItem(driver, GDAL_DMD_CREATIONDATATYPES, nullptr);
    const CPLStringList list(CSLTokenizeString(names ? names : ""));
    const auto written = [&](SampleType type) {
        return list.Count() == 0 ||
               list.FindString(GDALGetDataTypeName(detail::gdal_type(type))) >= 0;
    };
    if (written(raster.type)) return raster.type;
    for (const SampleType type :
         {SampleType::UInt8, SampleType::UInt16, SampleType::Int16, SampleType::UInt32,
          SampleType::Int32, SampleType::Float32, SampleType::Float64})
        if (written(type) && holds(raster, type)) return type;
    return Error{
        ErrorCode::InvalidArgument,
        fmt::format("{} files can not hold these {} values exactly (they hold {}); write .tif",
                    GDALGetDriverShortName(driver), sample_type_name(raster.type), names),
        path};
}

bool in_type(double value, SampleType type) {
    const auto [low, high] = sample_range(type);
    if (is_integer(type)) return value >= low && value <= high && value == std::nearbyint(value);
    return std::isnan(value) || (value >= low && value <= high);
}

/// A value of an integer type that no sample has: an end of the range, or beside the samples, or
/// between them.
std::optional<double> free_value(const Raster& raster, SampleType type) {
    const double low = sample_range(type).first;
    const double high = sample_range(type).second;
    const bool small = high - low <= 65535;
    std::vector<bool> used(small ? static_cast<std::size_t>(high - low) + 1 : 0);
    double smallest = high;
    double largest = low;
    all_valid(raster, [&](std::int64_t r, std::int64_t c) {
        for (const Grid<double>& plane : raster.planes) {
            const double value = stored_value(plane(r, c), type, {});
            smallest = std::min(smallest, value);
            largest = std::max(largest, value);
            if (small) used[static_cast<std::size_t>(value - low)] = true;
        }
        return true;
    });
    if (low < 0 && smallest > low) return low;
    if (largest < high) return high;
    if (smallest > low) return low;
    const auto gap = std::find(used.begin(), used.end(), false);
    if (gap == used.end()) return {};
    return low + static_cast<double>(gap - used.begin());
}

Result<HoleCode> choose_hole_code(const Raster& raster, SampleType type, GDALDriverH driver,
                                  const std::string& path) {
    HoleCode code;
    if (raster.nodata && in_type(*raster.nodata, type)) code.nodata = raster.nodata;
    if (code.nodata || !has_holes(raster)) return code;
    code.nodata =
        is_integer(type) ? free_value(raster, type) : std::numeric_limits<double>::quiet_NaN();
    code.mask_band = !code.nodata;
    if (code.mask_band && !EQUAL(GDALGetDriverShortName(driver), "GTiff"))
        return Error{
            ErrorCode::InvalidArgument,
            fmt::format("the samples use every {} value, none is left for the holes; write .tif",
                        sample_type_name(type)),
            path};
    return code;
}

bool write_mask(GDALDatasetH dataset, const Raster& raster) {
    if (GDALCreateDatasetMaskBand(dataset, GMF_PER_DATASET) != CE_None) return false;
    GDALRasterBandH band = GDALGetMaskBand(GDALGetRasterBand(dataset, 1));
    const int cols = static_cast<int>(raster.cols);
    std::vector<std::uint8_t> row(static_cast<std::size_t>(cols));
    for (int r = 0; r < static_cast<int>(raster.rows); ++r) {
        for (int c = 0; c < cols; ++c)
            row[static_cast<std::size_t>(c)] = is_hole(raster, r, c) ? 0 : 255;
        if (GDALRasterIO(band, GF_Write, 0, r, cols, 1, row.data(), cols, 1, GDT_Byte, 0, 0) !=
            CE_None)
            return false;
    }
    return true;
}

bool write_plane(GDALRasterBandH band, const Raster& raster, const Grid<double>& plane,
                 SampleType type, const HoleCode& code) {
    const int cols = static_cast<int>(raster.cols);
    std::vector<double> row(static_cast<std::size_t>(cols));
    for (int r = 0; r < static_cast<int>(raster.rows); ++r) {
        for (int c = 0; c < cols; ++c) {
            const double value = plane(r, c);
            row[static_cast<std::size_t>(c)] = is_hole(raster, r, c)
                                                   ? code.nodata.value_or(0)
                                                   : stored_value(value, type, code.nodata);
        }
        if (GDALRasterIO(band, GF_Write, 0, r, cols, 1, row.data(), cols, 1, GDT_Float64, 0, 0) !=
            CE_None)
            return false;
    }
    return true;
}

bool describe(GDALDatasetH dataset, const Raster& raster, const HoleCode& code) {
    const GeoReference& geo = raster.geo;
    std::array<double, 6> transform = geo.transform.value_or(std::array<double, 6>{});
    if (geo.transform && GDALSetGeoTransform(dataset, transform.data()) != CE_None) return false;
    if (!geo.crs_wkt.empty() && GDALSetProjection(dataset, geo.crs_wkt.c_str()) != CE_None)
        return false;
    for (const auto& [name, value] : raster.metadata)
        GDALSetMetadataItem(dataset, name.c_str(), value.c_str(), nullptr);
    if (geo.pixel_is_point) GDALSetMetadataItem(dataset, "AREA_OR_POINT", "Point", nullptr);
    for (std::size_t k = 0; k < raster.planes.size(); ++k) {
        GDALRasterBandH band = GDALGetRasterBand(dataset, static_cast<int>(k) + 1);
        if (code.nodata) GDALSetRasterNoDataValue(band, *code.nodata);
        if (!raster.unit.empty()) GDALSetRasterUnitType(band, raster.unit.c_str());
        if (raster.scale != 1 || raster.offset != 0) {
            GDALSetRasterScale(band, raster.scale);
            GDALSetRasterOffset(band, raster.offset);
        }
        if (!raster.band_names.empty()) GDALSetDescription(band, raster.band_names[k].c_str());
    }
    return true;
}

/// The raster as the file will hold it, in memory: what every driver can copy.
Result<Dataset> in_memory(const Raster& raster, SampleType type, const HoleCode& code,
                          const GdalScope& gdal, const std::string& path) {
    const Error failed{ErrorCode::CannotWrite, "can not prepare the raster", path};
    Dataset dataset(GDALCreate(GDALGetDriverByName("MEM"), "", static_cast<int>(raster.cols),
                               static_cast<int>(raster.rows),
                               static_cast<int>(raster.planes.size()), detail::gdal_type(type),
                               nullptr));
    bool done = dataset && describe(dataset.get(), raster, code) &&
                (!code.mask_band || write_mask(dataset.get(), raster));
    for (std::size_t k = 0; done && k < raster.planes.size(); ++k)
        done = write_plane(GDALGetRasterBand(dataset.get(), static_cast<int>(k) + 1), raster,
                           raster.planes[k], type, code);
    if (done) return dataset;
    return Error{failed.code, failed.message + gdal.because(), failed.where};
}

CPLStringList creation_options(const Raster& raster, SampleType type, GDALDriverH driver,
                               const WriteOptions& options) {
    CPLStringList list;
    if (EQUAL(GDALGetDriverShortName(driver), "GTiff")) {
        list.SetNameValue("COMPRESS", "DEFLATE");
        list.SetNameValue("PREDICTOR", is_integer(type) ? "2" : "3");
        list.SetNameValue("INTERLEAVE", "BAND");
        list.SetNameValue("BIGTIFF", "IF_SAFER");
        list.SetNameValue("NUM_THREADS", std::to_string(thread_count()).c_str());
        if (std::min(raster.rows, raster.cols) >= 256) list.SetNameValue("TILED", "YES");
    }
    for (const std::string& option : options.creation_options) {
        const std::size_t equals = option.find('=');
        list.SetNameValue(option.substr(0, equals).c_str(), option.substr(equals + 1).c_str());
    }
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

Status copy_to_file(GDALDriverH driver, GDALDatasetH source, const std::string& name,
                    const CPLStringList& list, const WriteOptions& options, const GdalScope& gdal,
                    const std::string& path) {
    const LocalSetting mask_inside("GDAL_TIFF_INTERNAL_MASK", "YES");
    bool cancelled = false;
    const Progress progress = [&](double fraction) {
        cancelled = options.progress && !options.progress(fraction);
        return !cancelled;
    };
    Dataset copy(GDALCreateCopy(driver, name.c_str(), source, TRUE, list.List(),
                                &detail::report_progress, const_cast<Progress*>(&progress)));
    const bool made = copy != nullptr;
    copy.reset();  // the last bytes are written here; whether that went well is in the messages
    if (cancelled) return Error{ErrorCode::Cancelled, "writing was cancelled", path};
    if (made && !gdal.failed()) return {};
    return Error{ErrorCode::CannotWrite,
                 fmt::format("can not write as {}{}; check the free space and the options",
                             GDALGetDriverShortName(driver), gdal.because()),
                 path};
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

}  // namespace

Status write_raster(const std::string& path, const Raster& raster, const WriteOptions& options) {
    const GdalScope gdal;
    RELIEF_CHECK(check(raster, path));
    RELIEF_CHECK(check_options(options, path));
    RELIEF_TRY(GDALDriverH driver, choose_driver(path, options));
    RELIEF_TRY(const SampleType type, choose_type(raster, driver, path));
    RELIEF_TRY(const HoleCode code, choose_hole_code(raster, type, driver, path));
    const CPLStringList list = creation_options(raster, type, driver, options);
    const auto write_to = [&](const std::string& name) -> Status {
        RELIEF_TRY(const Dataset memory, in_memory(raster, type, code, gdal, path));
        return copy_to_file(driver, memory.get(), name, list, options, gdal, path);
    };
    if (detail::is_virtual_path(path)) {
        Status status = write_to(path);
        if (!status) VSIUnlink(path.c_str());
        return status;
    }
    RELIEF_TRY(StagedOutput staged, StagedOutput::beside(path));
    RELIEF_CHECK(write_to(staged.temporary_path()));
    const std::vector<std::string> stale = stale_side_files(path, staged.temporary_path());
    RELIEF_CHECK(staged.commit());
    for (const std::string& file : stale) {
        std::error_code error;
        std::filesystem::remove(file, error);
    }
    return {};
}

}  // namespace relief::io
