#include <cpl_conv.h>
#include <cpl_string.h>
#include <fmt/format.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "io/gdal_scope.h"

namespace relief::io {

namespace {

using detail::Dataset;
using detail::GdalScope;

constexpr double kHole = std::numeric_limits<double>::quiet_NaN();

/// The bands that become planes, and whether their values are signed bytes that GDAL reports as
/// unsigned ones.
struct Bands {
    std::vector<GDALRasterBandH> planes;
    SampleType type = SampleType::Float32;
    bool signed_bytes = false;
};

Result<Dataset> open(const std::string& path, const GdalScope& gdal) {
    Dataset dataset(GDALOpenEx(path.c_str(),
                               GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, nullptr,
                               nullptr, nullptr));
    if (dataset) return dataset;
    std::error_code error;
    if (!detail::is_virtual_path(path) && !std::filesystem::exists(path, error))
        return Error{ErrorCode::NotFound, "no such file; check the path", path};
    if (std::filesystem::is_directory(path, error))
        return Error{ErrorCode::BadInput, "is a directory; name a raster file in it", path};
    return Error{ErrorCode::BadInput,
                 "not a raster that GDAL can read; see gdalinfo --formats" + gdal.because(), path};
}

Error no_bands(GDALDatasetH dataset, const std::string& path) {
    const CSLConstList subdatasets = GDALGetMetadata(dataset, "SUBDATASETS");
    const char* first = CSLFetchNameValue(subdatasets, "SUBDATASET_1_NAME");
    if (!first) return {ErrorCode::BadInput, "has no raster band", path};
    return {ErrorCode::BadInput,
            fmt::format("holds {} subdatasets; name one of them, such as '{}'",
                        CSLCount(subdatasets) / 2, first),
            path};
}

Result<SampleType> sample_type(GDALDataType type, const std::string& path) {
    switch (type) {
        case GDT_Byte:
            return SampleType::UInt8;
        case GDT_UInt16:
            return SampleType::UInt16;
        case GDT_Int16:
            return SampleType::Int16;
        case GDT_UInt32:
            return SampleType::UInt32;
        case GDT_Int32:
            return SampleType::Int32;
        case GDT_Float32:
            return SampleType::Float32;
        case GDT_Float64:
            return SampleType::Float64;
        default:
            break;
    }
    const std::string name = GDALGetDataTypeName(type);
    if (name == "Int8") return SampleType::Int16;
    const char* advice = GDALDataTypeIsComplex(type)
                             ? "take one part of it: gdal_translate -ot Float64"
                             : "convert it: gdal_translate -ot Float64";
    return Error{ErrorCode::BadInput,
                 fmt::format("samples of type {} are not supported; {}", name, advice), path};
}

/// The narrowest type that holds the values of both exactly.
SampleType common_type(SampleType a, SampleType b) {
    if (a == b) return a;
    const auto exact_in_float32 = [](SampleType type) {
        return type == SampleType::Float32 || sample_range(type).second <= 65535;
    };
    if (!is_integer(a) || !is_integer(b))
        return exact_in_float32(a) && exact_in_float32(b) ? SampleType::Float32
                                                          : SampleType::Float64;
    const double low = std::min(sample_range(a).first, sample_range(b).first);
    const double high = std::max(sample_range(a).second, sample_range(b).second);
    for (const SampleType type :
         {SampleType::UInt16, SampleType::Int16, SampleType::UInt32, SampleType::Int32})
        if (low >= sample_range(type).first && high <= sample_range(type).second) return type;
    return SampleType::Float64;
}

Result<Bands> select_bands(GDALDatasetH dataset, const std::string& path) {
    Bands bands;
    for (int k = 1; k <= GDALGetRasterCount(dataset); ++k) {
        GDALRasterBandH band = GDALGetRasterBand(dataset, k);
        if (GDALGetRasterColorInterpretation(band) != GCI_AlphaBand) bands.planes.push_back(band);
    }
    if (bands.planes.empty()) return no_bands(dataset, path);
    if (bands.planes.size() > 4)
        return Error{
            ErrorCode::BadInput,
            fmt::format("has {} bands, at most 4 are supported; choose some: gdal_translate -b 1",
                        bands.planes.size()),
            path};
    for (GDALRasterBandH band : bands.planes) {
        RELIEF_TRY(SampleType type, sample_type(GDALGetRasterDataType(band), path));
        const char* pixel = GDALGetMetadataItem(band, "PIXELTYPE", "IMAGE_STRUCTURE");
        if (type == SampleType::UInt8 && pixel && EQUAL(pixel, "SIGNEDBYTE")) {
            bands.signed_bytes = true;
            type = SampleType::Int16;
        }
        bands.type = band == bands.planes.front() ? type : common_type(bands.type, type);
    }
    return bands;
}

Result<LatticeBox> checked_window(GDALDatasetH dataset, const ReadOptions& options,
                                  const std::string& path) {
    const std::int64_t rows = GDALGetRasterYSize(dataset);
    const std::int64_t cols = GDALGetRasterXSize(dataset);
    if (rows < 1 || cols < 1) return Error{ErrorCode::BadInput, "has no samples", path};
    const LatticeBox box = options.window.value_or(LatticeBox{0, 0, rows, cols});
    const auto inside = [](std::int64_t first, std::int64_t count, std::int64_t size) {
        return first >= 0 && count >= 1 && first < size && count <= size - first;
    };
    if (inside(box.row0, box.rows, rows) && inside(box.col0, box.cols, cols)) return box;
    return Error{ErrorCode::InvalidArgument,
                 fmt::format("the window {},{},{},{} is not inside the {} x {} raster", box.col0,
                             box.row0, box.cols, box.rows, cols, rows),
                 path};
}

GeoReference read_geo(GDALDatasetH dataset, const LatticeBox& box) {
    GeoReference geo;
    std::array<double, 6> t{};
    if (GDALGetGeoTransform(dataset, t.data()) == CE_None) {
        const auto col = static_cast<double>(box.col0);
        const auto row = static_cast<double>(box.row0);
        t[0] += t[1] * col + t[2] * row;
        t[3] += t[4] * col + t[5] * row;
        geo.transform = t;
    }
    if (OGRSpatialReferenceH crs = GDALGetSpatialRef(dataset)) {
        char* wkt = nullptr;
        const char* const format[] = {"FORMAT=WKT2_2019", nullptr};
        if (OSRExportToWktEx(crs, &wkt, format) == OGRERR_NONE) geo.crs_wkt = wkt;
        CPLFree(wkt);
    }
    const char* meaning = GDALGetMetadataItem(dataset, "AREA_OR_POINT", nullptr);
    geo.pixel_is_point = meaning && EQUAL(meaning, "Point");
    return geo;
}

void read_description(GDALDatasetH dataset, const Bands& bands, Raster& raster) {
    GDALRasterBandH first = bands.planes.front();
    int has = FALSE;
    const double nodata = GDALGetRasterNoDataValue(first, &has);
    if (has) raster.nodata = nodata;
    raster.unit = GDALGetRasterUnitType(first);
    const double scale = GDALGetRasterScale(first, &has);
    if (has) raster.scale = scale;
    const double offset = GDALGetRasterOffset(first, &has);
    if (has) raster.offset = offset;

    bool named = false;
    for (GDALRasterBandH band : bands.planes) {
        raster.band_names.emplace_back(GDALGetDescription(band));
        named = named || !raster.band_names.back().empty();
    }
    if (!named) raster.band_names.clear();
    const CSLConstList items = GDALGetMetadata(dataset, nullptr);
    for (int k = 0; items && items[k]; ++k) {
        const std::string item = items[k];
        const std::size_t equals = item.find('=');
        if (equals == std::string::npos || item.starts_with("AREA_OR_POINT=")) continue;
        raster.metadata.emplace_back(item.substr(0, equals), item.substr(equals + 1));
    }
}

/// Reads `count` rows of `window` from its row `row` into the raster; mask rows become 0 where this
/// band has holes.
bool read_rows(GDALRasterBandH band, const LatticeBox& window, std::int64_t row, std::int64_t count,
               Grid<double>& plane, Grid<std::uint8_t>& mask) {
    const int x = static_cast<int>(window.col0);
    const int y = static_cast<int>(window.row0 + row);
    const int width = static_cast<int>(window.cols);
    const int height = static_cast<int>(count);
    if (GDALRasterIOEx(band, GF_Read, x, y, width, height, plane.row(row), width, height,
                       GDT_Float64, sizeof(double),
                       plane.stride() * static_cast<GSpacing>(sizeof(double)), nullptr) != CE_None)
        return false;
    if ((GDALGetMaskFlags(band) & GMF_ALL_VALID) != 0) return true;
    Grid<std::uint8_t> seen(count, window.cols);
    if (GDALRasterIOEx(GDALGetMaskBand(band), GF_Read, x, y, width, height, seen.row(0), width,
                       height, GDT_Byte, 1, seen.stride(), nullptr) != CE_None)
        return false;
    for (std::int64_t r = 0; r < count; ++r)
        for (std::int64_t c = 0; c < window.cols; ++c)
            if (seen(r, c) == 0) mask(row + r, c) = 0;
    return true;
}

/// Signed bytes get their sign; what is not finite becomes a hole.
void normalise(Grid<double>& plane, bool signed_bytes, std::int64_t row, std::int64_t count,
               Grid<std::uint8_t>& mask) {
    for (std::int64_t r = row; r < row + count; ++r) {
        for (std::int64_t c = 0; c < plane.cols(); ++c) {
            double& value = plane(r, c);
            if (signed_bytes && value > 127) value -= 256;
            if (!std::isfinite(value)) mask(r, c) = 0;
        }
    }
}

Status read_samples(const Bands& bands, const LatticeBox& window, const ReadOptions& options,
                    const GdalScope& gdal, const std::string& path, Raster& raster) {
    int block_cols = 1;
    int block_rows = 1;
    GDALGetBlockSize(bands.planes.front(), &block_cols, &block_rows);
    // Whole rows of blocks, about a million samples at a time, so that each block is decoded once.
    const std::int64_t wanted = std::max<std::int64_t>(1, (std::int64_t{1} << 20) / window.cols);
    const std::int64_t step = (wanted + block_rows - 1) / block_rows * block_rows;
    for (std::int64_t row = 0; row < window.rows; row += step) {
        const std::int64_t count = std::min(step, window.rows - row);
        for (std::size_t k = 0; k < bands.planes.size(); ++k) {
            if (!read_rows(bands.planes[k], window, row, count, raster.planes[k], raster.mask))
                return Error{ErrorCode::BadFile,
                             "can not read the samples; the file is damaged" + gdal.because(),
                             fmt::format("{}, row {}", path, window.row0 + row)};
            normalise(raster.planes[k], bands.signed_bytes, row, count, raster.mask);
        }
        const double fraction = static_cast<double>(row + count) / static_cast<double>(window.rows);
        if (options.progress && !options.progress(fraction))
            return Error{ErrorCode::Cancelled, "reading was cancelled", path};
    }
    return {};
}

/// Holes become NaN in every plane; a mask without holes goes.
void finish_holes(Raster& raster) {
    bool holes = false;
    for (std::int64_t r = 0; r < raster.rows; ++r) {
        for (std::int64_t c = 0; c < raster.cols; ++c) {
            if (raster.mask(r, c) != 0) continue;
            holes = true;
            for (Grid<double>& plane : raster.planes) plane(r, c) = kHole;
        }
    }
    if (!holes) raster.mask = {};
}

}  // namespace

Result<Raster> read_raster(const std::string& path, const ReadOptions& options) {
    const GdalScope gdal;
    RELIEF_TRY(const Dataset dataset, open(path, gdal));
    RELIEF_TRY(const Bands bands, select_bands(dataset.get(), path));
    RELIEF_TRY(const LatticeBox window, checked_window(dataset.get(), options, path));
    constexpr std::int64_t most = std::int64_t{1} << 40;
    if (window.rows > most / window.cols)
        return Error{ErrorCode::BadInput,
                     fmt::format("{} x {} samples are too many for memory; read a window",
                                 window.cols, window.rows),
                     path};
    Raster raster;
    raster.rows = window.rows;
    raster.cols = window.cols;
    raster.type = bands.type;
    raster.geo = read_geo(dataset.get(), window);
    read_description(dataset.get(), bands, raster);
    for (std::size_t k = 0; k < bands.planes.size(); ++k)
        raster.planes.emplace_back(raster.rows, raster.cols);
    raster.mask = Grid<std::uint8_t>(raster.rows, raster.cols, 1);
    RELIEF_CHECK(read_samples(bands, window, options, gdal, path, raster));
    finish_holes(raster);
    return raster;
}

}  // namespace relief::io
