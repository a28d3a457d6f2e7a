#include <cpl_string.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/raster_output.h"

namespace relief::io {

namespace {

using detail::Dataset;
using detail::GdalScope;
using detail::HoleCode;

/// Calls visit(row, col) for every sample that is not a hole, until it returns false.
template <class Visit>
bool all_valid(const Raster& raster, Visit visit) {
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            if (!detail::is_hole(raster, r, c) && !visit(r, c)) return false;
    return true;
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
        return list.Count() == 0 || list.FindString(GDALGetDataTypeName(gdal_type(type))) >= 0;
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
    if (raster.nodata && detail::in_type(*raster.nodata, type)) code.nodata = raster.nodata;
    if (code.nodata || !detail::row_with_hole(raster)) return code;
    code.nodata =
        is_integer(type) ? free_value(raster, type) : std::numeric_limits<double>::quiet_NaN();
    code.mask_band = !code.nodata;
    if (code.mask_band && !detail::is_geotiff(driver))
        return Error{
            ErrorCode::InvalidArgument,
            fmt::format("the samples use every {} value, none is left for the holes; write .tif",
                        sample_type_name(type)),
            path};
    return code;
}

Error cancelled(const std::string& path) {
    return {ErrorCode::Cancelled, "writing was cancelled", path};
}

Status write_geotiff(const std::string& path, const Raster& raster, const HoleCode& code,
                     const WriteOptions& options) {
    RELIEF_TRY(detail::TiffOutput file,
               detail::TiffOutput::create(path, raster, raster.planes.size(), code, options));
    const std::int64_t step = std::max<std::int64_t>(1, (std::int64_t{1} << 20) / raster.cols);
    for (std::int64_t row = 0; row < raster.rows; row += step) {
        const std::int64_t count = std::min(step, raster.rows - row);
        RELIEF_CHECK(file.write(raster, row, count));
        const double fraction = static_cast<double>(row + count) / static_cast<double>(raster.rows);
        if (options.progress && !options.progress(fraction)) return cancelled(path);
    }
    return file.commit();
}

/// The raster as the file will hold it, in memory: what every driver can copy.
Result<Dataset> in_memory(const Raster& raster, SampleType type, const HoleCode& code,
                          const GdalScope& gdal, const std::string& path) {
    Dataset dataset(GDALCreate(GDALGetDriverByName("MEM"), "", static_cast<int>(raster.cols),
                               static_cast<int>(raster.rows),
                               static_cast<int>(raster.planes.size()), gdal_type(type), nullptr));
    if (dataset && detail::describe(dataset.get(), raster, raster.planes.size(), code) &&
        detail::BlockWriter(dataset.get(), type, code).write(raster, 0, raster.rows))
        return dataset;
    return Error{ErrorCode::CannotWrite, "can not prepare the raster" + gdal.because(), path};
}

Status write_copy(const std::string& path, const Raster& raster, GDALDriverH driver,
                  SampleType type, const HoleCode& code, const WriteOptions& options) {
    const GdalScope gdal;
    RELIEF_TRY(detail::Destination destination, detail::Destination::at(path));
    RELIEF_TRY(const Dataset memory, in_memory(raster, type, code, gdal, path));
    CPLStringList list;
    detail::add_creation_options(options, list);
    bool stopped = false;
    const Progress progress = [&](double fraction) {
        stopped = options.progress && !options.progress(fraction);
        return !stopped;
    };
    Dataset copy(GDALCreateCopy(driver, destination.name().c_str(), memory.get(), TRUE, list.List(),
                                &detail::report_progress, const_cast<Progress*>(&progress)));
    const bool made = copy != nullptr;
    copy.reset();  // the last bytes are written here; whether that went well is in the messages
    if (stopped) return cancelled(path);
    if (!made || gdal.failed()) return detail::cannot_write_as(driver, gdal, path);
    return destination.commit();
}

}  // namespace

Status write_raster(const std::string& path, const Raster& raster, const WriteOptions& options) {
    const GdalScope gdal;
    RELIEF_CHECK(detail::check_description(raster, raster.planes.size(), path));
    RELIEF_CHECK(detail::check_samples(raster, path));
    RELIEF_TRY(GDALDriverH driver, detail::choose_driver(path, options));
    RELIEF_TRY(const SampleType type, choose_type(raster, driver, path));
    RELIEF_TRY(const HoleCode code, choose_hole_code(raster, type, driver, path));
    if (detail::is_geotiff(driver)) return write_geotiff(path, raster, code, options);
    return write_copy(path, raster, driver, type, code, options);
}

}  // namespace relief::io
