#include <cpl_conv.h>
#include <cpl_string.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <mutex>

#include "io/gdal_scope.h"
#include "io/spatial_reference.h"
#include "relief/core/parallel.h"

namespace relief::io {

namespace {

using detail::Dataset;
using detail::GdalScope;

constexpr double kHole = std::numeric_limits<double>::quiet_NaN();

/// A band that becomes a plane.
struct Band {
    GDALRasterBandH handle = nullptr;
    SampleType type = SampleType::Float32;
    bool signed_bytes = false;  ///< which GDAL reports as unsigned ones
    int block_cols = 1;
    int block_rows = 1;
};

Result<Dataset> open_dataset(const std::string& path, const GdalScope& gdal) {
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

Result<Band> inspect_band(GDALRasterBandH handle, const std::string& path) {
    Band band{.handle = handle};
    RELIEF_TRY(band.type, sample_type(GDALGetRasterDataType(handle), path));
    const char* pixel = GDALGetMetadataItem(handle, "PIXELTYPE", "IMAGE_STRUCTURE");
    band.signed_bytes = band.type == SampleType::UInt8 && pixel && EQUAL(pixel, "SIGNEDBYTE");
    if (band.signed_bytes) band.type = SampleType::Int16;
    GDALGetBlockSize(handle, &band.block_cols, &band.block_rows);
    return band;
}

Result<std::vector<Band>> select_bands(GDALDatasetH dataset, const std::string& path) {
    std::vector<GDALRasterBandH> handles;
    for (int k = 1; k <= GDALGetRasterCount(dataset); ++k) {
        GDALRasterBandH band = GDALGetRasterBand(dataset, k);
        if (GDALGetRasterColorInterpretation(band) != GCI_AlphaBand) handles.push_back(band);
    }
    if (handles.empty()) return no_bands(dataset, path);
    if (handles.size() > 4)
        return Error{
            ErrorCode::BadInput,
            fmt::format("has {} bands, at most 4 are supported; choose some: gdal_translate -b 1",
                        handles.size()),
            path};
    std::vector<Band> bands;
    for (GDALRasterBandH handle : handles) {
        RELIEF_TRY(bands.emplace_back(), inspect_band(handle, path));
    }
    return bands;
}

GeoReference read_geo(GDALDatasetH dataset) {
    GeoReference geo;
    std::array<double, 6> transform{};
    if (GDALGetGeoTransform(dataset, transform.data()) == CE_None) geo.transform = transform;
    if (OGRSpatialReferenceH crs = GDALGetSpatialRef(dataset)) geo.crs = detail::crs_of(crs);
    const char* meaning = GDALGetMetadataItem(dataset, "AREA_OR_POINT", nullptr);
    geo.pixel_is_point = meaning && EQUAL(meaning, "Point");
    return geo;
}

std::vector<std::pair<std::string, std::string>> read_metadata(GDALDatasetH dataset) {
    std::vector<std::pair<std::string, std::string>> metadata;
    const CSLConstList items = GDALGetMetadata(dataset, nullptr);
    for (int k = 0; items && items[k]; ++k) {
        const std::string item = items[k];
        const std::size_t equals = item.find('=');
        if (equals == std::string::npos || item.starts_with("AREA_OR_POINT=")) continue;
        metadata.emplace_back(item.substr(0, equals), item.substr(equals + 1));
    }
    return metadata;
}

Raster describe(GDALDatasetH dataset, const std::vector<Band>& bands) {
    Raster raster;
    raster.rows = GDALGetRasterYSize(dataset);
    raster.cols = GDALGetRasterXSize(dataset);
    raster.geo = read_geo(dataset);
    raster.metadata = read_metadata(dataset);

    GDALRasterBandH first = bands.front().handle;
    int has = FALSE;
    const double nodata = GDALGetRasterNoDataValue(first, &has);
    if (has) raster.nodata = nodata;
    raster.unit = GDALGetRasterUnitType(first);
    const double scale = GDALGetRasterScale(first, &has);
    if (has) raster.scale = scale;
    const double offset = GDALGetRasterOffset(first, &has);
    if (has) raster.offset = offset;

    raster.type = bands.front().type;
    bool named = false;
    for (const Band& band : bands) {
        raster.type = common_type(raster.type, band.type);
        raster.band_names.emplace_back(GDALGetDescription(band.handle));
        named = named || !raster.band_names.back().empty();
    }
    if (!named) raster.band_names.clear();
    return raster;
}

bool has_mask(const Band& band) {
    return (GDALGetMaskFlags(band.handle) & GMF_ALL_VALID) == 0;
}

/// What the blocks across the raster take, of all bands and masks.
double bytes_of_block_row(const std::vector<Band>& bands, std::int64_t raster_cols) {
    double bytes = 0;
    for (const Band& band : bands) {
        const std::int64_t across = (raster_cols + band.block_cols - 1) / band.block_cols;
        const double samples = static_cast<double>(across) * band.block_cols * band.block_rows;
        const int sample = GDALGetDataTypeSizeBytes(GDALGetRasterDataType(band.handle));
        bytes += samples * (sample + (has_mask(band) ? 1 : 0));
    }
    return bytes;
}

/// Reads `count` rows of `window` from its row `row` into the plane; the mask becomes 0 where this
/// band has holes.
bool read_band(const Band& band, const LatticeBox& window, std::int64_t row, std::int64_t count,
               Grid<double>& plane, Grid<std::uint8_t>& mask) {
    const int x = static_cast<int>(window.col0);
    const int y = static_cast<int>(window.row0 + row);
    const int width = static_cast<int>(window.cols);
    const int height = static_cast<int>(count);
    if (GDALRasterIOEx(band.handle, GF_Read, x, y, width, height, plane.row(row), width, height,
                       GDT_Float64, sizeof(double),
                       plane.stride() * static_cast<GSpacing>(sizeof(double)), nullptr) != CE_None)
        return false;
    if (!has_mask(band)) return true;
    Grid<std::uint8_t> seen(count, window.cols);
    if (GDALRasterIOEx(GDALGetMaskBand(band.handle), GF_Read, x, y, width, height, seen.row(0),
                       width, height, GDT_Byte, 1, seen.stride(), nullptr) != CE_None)
        return false;
    for (std::int64_t r = 0; r < count; ++r)
        for (std::int64_t c = 0; c < window.cols; ++c)
            if (seen(r, c) == 0) mask(row + r, c) = 0;
    return true;
}

/// Signed bytes get their sign; what is not finite in one plane, or masked, becomes NaN in all.
/// Returns whether the row has such holes.
bool finish_row(const std::vector<Band>& bands, std::int64_t row, Raster& raster) {
    std::uint8_t* mask = raster.mask.row(row);
    for (std::size_t k = 0; k < bands.size(); ++k) {
        double* plane = raster.planes[k].row(row);
        for (std::int64_t c = 0; c < raster.cols; ++c) {
            if (bands[k].signed_bytes && plane[c] > 127) plane[c] -= 256;
            if (!std::isfinite(plane[c])) mask[c] = 0;
        }
    }
    if (std::find(mask, mask + raster.cols, 0) == mask + raster.cols) return false;
    for (Grid<double>& plane : raster.planes)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            if (mask[c] == 0) plane(row, c) = kHole;
    return true;
}

}  // namespace

struct RasterReader::File {
    std::string path;
    Dataset owned;  ///< null: somebody else's
    GDALDatasetH dataset = nullptr;
    std::vector<Band> bands;
    Raster description;
    std::int64_t step = 1;  ///< rows read at a time: whole blocks, about a million samples
    std::optional<detail::CacheRoom> room = {};
    std::mutex gdal;  ///< a dataset serves one thread at a time

    ~File() {
        const GdalScope quiet;
        owned.reset();
    }

    [[nodiscard]] Status check(const LatticeBox& window) const;
    [[nodiscard]] Raster prepare(const LatticeBox& window) const;
    /// Fills rows row .. row + count - 1 of the part that is the window. Returns whether they have
    /// holes.
    Result<bool> read_rows(const LatticeBox& window, std::int64_t row, std::int64_t count,
                           Raster& part);
};

Status RasterReader::File::check(const LatticeBox& window) const {
    const auto inside = [](std::int64_t first, std::int64_t count, std::int64_t size) {
        return first >= 0 && count >= 1 && first < size && count <= size - first;
    };
    if (!inside(window.row0, window.rows, description.rows) ||
        !inside(window.col0, window.cols, description.cols))
        return Error{
            ErrorCode::InvalidArgument,
            fmt::format("the window {},{},{},{} is not inside the {} x {} raster", window.col0,
                        window.row0, window.cols, window.rows, description.cols, description.rows),
            path};
    constexpr std::int64_t most = std::int64_t{1} << 40;
    if (window.rows > most / window.cols)
        return Error{ErrorCode::BadInput,
                     fmt::format("{} x {} samples are too many for memory; read a window",
                                 window.cols, window.rows),
                     path};
    return {};
}

Raster RasterReader::File::prepare(const LatticeBox& window) const {
    Raster part = description_of(description);
    part.rows = window.rows;
    part.cols = window.cols;
    if (part.geo.transform) {
        std::array<double, 6>& t = *part.geo.transform;
        const auto col = static_cast<double>(window.col0);
        const auto row = static_cast<double>(window.row0);
        t[0] += t[1] * col + t[2] * row;
        t[3] += t[4] * col + t[5] * row;
    }
    for (std::size_t k = 0; k < bands.size(); ++k) part.planes.emplace_back(part.rows, part.cols);
    part.mask = Grid<std::uint8_t>(part.rows, part.cols, 1);
    return part;
}

Result<bool> RasterReader::File::read_rows(const LatticeBox& window, std::int64_t row,
                                           std::int64_t count, Raster& part) {
    {
        const GdalScope messages;
        const std::lock_guard lock(gdal);
        for (std::size_t k = 0; k < bands.size(); ++k)
            if (!read_band(bands[k], window, row, count, part.planes[k], part.mask))
                return Error{ErrorCode::BadFile,
                             "can not read the samples; the file is damaged" + messages.because(),
                             fmt::format("{}, row {}", path, window.row0 + row)};
    }
    std::atomic<bool> holes = false;
    parallel_for(row, row + count, 16, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r)
            if (finish_row(bands, r, part)) holes = true;
    });
    return holes.load();
}

RasterReader::RasterReader(std::unique_ptr<File> file) : file_(std::move(file)) {}
RasterReader::RasterReader(RasterReader&& other) noexcept
    : RasterSource(), file_(std::move(other.file_)) {}
RasterReader::~RasterReader() = default;

Result<RasterReader> RasterReader::create(std::unique_ptr<File> file) {
    RELIEF_TRY(file->bands, select_bands(file->dataset, file->path));
    file->description = describe(file->dataset, file->bands);
    const std::int64_t cols = file->description.cols;
    if (file->description.rows < 1 || cols < 1)
        return Error{ErrorCode::BadInput, "has no samples", file->path};
    const std::int64_t block_rows = file->bands.front().block_rows;
    file->step =
        std::max<std::int64_t>(1, (std::int64_t{1} << 20) / cols / block_rows) * block_rows;
    file->room.emplace(bytes_of_block_row(file->bands, cols));
    return RasterReader(std::move(file));
}

Result<RasterReader> RasterReader::open(const std::string& path) {
    const GdalScope gdal;
    auto file = std::make_unique<File>();
    file->path = path;
    RELIEF_TRY(file->owned, open_dataset(path, gdal));
    file->dataset = file->owned.get();
    return create(std::move(file));
}

Result<RasterReader> reader_of(GDALDatasetH dataset) {
    const GdalScope gdal;
    auto file = std::make_unique<RasterReader::File>();
    file->path = GDALGetDescription(dataset);
    file->dataset = dataset;
    return RasterReader::create(std::move(file));
}

const Raster& RasterReader::description() const {
    return file_->description;
}

int RasterReader::components() const {
    return static_cast<int>(file_->bands.size());
}

Result<Raster> RasterReader::read(const LatticeBox& window) const {
    return read(window, {});
}

Result<Raster> RasterReader::read(const LatticeBox& window, const Progress& progress) const {
    RELIEF_CHECK(file_->check(window));
    Raster part = file_->prepare(window);
    bool holes = false;
    for (std::int64_t row = 0; row < window.rows;) {
        // Up to the end of a row of blocks, so that each block is decoded once.
        const std::int64_t reach = file_->step - (window.row0 + row) % file_->step;
        const std::int64_t count = std::min(reach, window.rows - row);
        RELIEF_TRY(const bool some, file_->read_rows(window, row, count, part));
        holes = holes || some;
        row += count;
        const double fraction = static_cast<double>(row) / static_cast<double>(window.rows);
        if (progress && !progress(fraction))
            return Error{ErrorCode::Cancelled, "reading was cancelled", file_->path};
    }
    if (!holes) part.mask = {};
    return part;
}

Result<Raster> read_raster(const std::string& path, const ReadOptions& options) {
    RELIEF_TRY(const RasterReader reader, RasterReader::open(path));
    const Raster& whole = reader.description();
    return reader.read(options.window.value_or(LatticeBox{0, 0, whole.rows, whole.cols}),
                       options.progress);
}

}  // namespace relief::io
