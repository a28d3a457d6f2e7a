#include "relief/io/drape.h"

#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_utils.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "io/gdal_scope.h"
#include "relief/io/file.h"

namespace relief::io {

namespace {

using detail::Dataset;

/// Formats whose files refer to no other files.
constexpr std::array<const char*, 8> kDrivers = {"GTiff", "PNG", "JPEG",        "WEBP",
                                                 "BMP",   "GIF", "JP2OpenJPEG", nullptr};

struct FreeStrings {
    void operator()(char** list) const { CSLDestroy(list); }
};
class Words {
  public:
    explicit Words(const std::vector<std::string>& words) {
        for (const std::string& word : words)
            list_.reset(CSLAddString(list_.release(), word.c_str()));
    }
    [[nodiscard]] char** get() const { return list_.get(); }

  private:
    std::unique_ptr<char*, FreeStrings> list_;
};

struct Extent {
    int width = 0;
    int height = 0;
};

/// The same shape with at most `largest` pixels a side.
Extent limited(std::int64_t cols, std::int64_t rows, int largest) {
    const double shrink = std::min(1.0, largest / static_cast<double>(std::max(cols, rows)));
    const auto side = [&](std::int64_t n) {
        return std::max(1, static_cast<int>(std::lround(static_cast<double>(n) * shrink)));
    };
    return {side(cols), side(rows)};
}

/// The bands that are red, green, blue, and the mask: as translation calls them.
std::vector<std::string> colours_of(GDALDatasetH source) {
    GDALRasterBandH first = GDALGetRasterBand(source, 1);
    std::vector<std::string> words = {"-of", "VRT"};
    const auto add = [&](std::initializer_list<const char*> more) {
        words.insert(words.end(), more.begin(), more.end());
    };
    if (GDALGetRasterColorInterpretation(first) == GCI_PaletteIndex) {
        add({"-expand", "rgba"});
        return words;
    }
    if (GDALGetRasterCount(source) >= 3)
        add({"-b", "1", "-b", "2", "-b", "3", "-b", "mask"});
    else
        add({"-b", "1", "-b", "1", "-b", "1", "-b", "mask"});
    add({"-colorinterp", "red,green,blue,alpha"});
    if (GDALGetRasterDataType(first) != GDT_Byte)
        add({"-ot", "Byte", "-scale_1", "-scale_2", "-scale_3"});
    return words;
}

Dataset in_colours(GDALDatasetH source) {
    const Words words(colours_of(source));
    const std::unique_ptr<GDALTranslateOptions, decltype(&GDALTranslateOptionsFree)> options(
        GDALTranslateOptionsNew(words.get(), nullptr), &GDALTranslateOptionsFree);
    if (!options) return nullptr;
    return Dataset(GDALTranslate("", source, options.get(), nullptr));
}

bool is_placed(GDALDatasetH picture, const Raster* terrain) {
    std::array<double, 6> transform{};
    return terrain && terrain->geo.transform && !terrain->geo.crs.empty() &&
           GDALGetGeoTransform(picture, transform.data()) == CE_None &&
           GDALGetSpatialRef(picture) != nullptr;
}

/// Empty pixels over the cells of the raster.
Dataset canvas_over(const Raster& terrain, const Extent& size) {
    Dataset canvas(
        GDALCreate(GDALGetDriverByName("MEM"), "", size.width, size.height, 4, GDT_Byte, nullptr));
    if (!canvas) return canvas;
    std::array<double, 6> transform = *terrain.geo.transform;
    const double across = static_cast<double>(terrain.cols) / size.width;
    const double down = static_cast<double>(terrain.rows) / size.height;
    for (const std::size_t k : {1U, 4U}) transform[k] *= across;
    for (const std::size_t k : {2U, 5U}) transform[k] *= down;
    GDALSetGeoTransform(canvas.get(), transform.data());
    const std::unique_ptr<void, decltype(&OSRDestroySpatialReference)> crs(
        OSRNewSpatialReference(nullptr), &OSRDestroySpatialReference);
    if (OSRSetFromUserInput(crs.get(), terrain.geo.crs.c_str()) != OGRERR_NONE) return nullptr;
    OSRSetAxisMappingStrategy(crs.get(), OAMS_TRADITIONAL_GIS_ORDER);
    GDALSetSpatialRef(canvas.get(), crs.get());
    constexpr std::array<GDALColorInterp, 4> colours = {GCI_RedBand, GCI_GreenBand, GCI_BlueBand,
                                                        GCI_AlphaBand};
    for (int band = 0; band < 4; ++band)
        GDALSetRasterColorInterpretation(GDALGetRasterBand(canvas.get(), band + 1),
                                         colours[static_cast<std::size_t>(band)]);
    return canvas;
}

Dataset warped(GDALDatasetH picture, const Raster& terrain, int largest) {
    // As many pixels a cell as the picture could have if it were not larger than the raster.
    const std::int64_t pixels = std::max(GDALGetRasterXSize(picture), GDALGetRasterYSize(picture));
    const std::int64_t samples = std::max(terrain.cols, terrain.rows);
    const std::int64_t finer = std::max<std::int64_t>(1, (pixels + samples - 1) / samples);
    Dataset canvas =
        canvas_over(terrain, limited(terrain.cols * finer, terrain.rows * finer, largest));
    if (!canvas) return canvas;
    const Words words({"-r", "bilinear", "-srcalpha"});
    const std::unique_ptr<GDALWarpAppOptions, decltype(&GDALWarpAppOptionsFree)> options(
        GDALWarpAppOptionsNew(words.get(), nullptr), &GDALWarpAppOptionsFree);
    if (!options || !GDALWarp(nullptr, canvas.get(), 1, &picture, options.get(), nullptr))
        return nullptr;
    return canvas;
}

/// All four bands, averaged down to a size.
bool read_pixels(GDALDatasetH picture, Image& image) {
    GDALRasterIOExtraArg how;
    INIT_RASTERIO_EXTRA_ARG(how);
    how.eResampleAlg = GRIORA_Average;
    return GDALDatasetRasterIOEx(picture, GF_Read, 0, 0, GDALGetRasterXSize(picture),
                                 GDALGetRasterYSize(picture), image.pixels.data(), image.width,
                                 image.height, GDT_Byte, 4, nullptr, 4, GSpacing{4} * image.width,
                                 1, &how) == CE_None;
}

}  // namespace

Result<Image> read_drape(const std::string& path, const Raster* terrain, int largest) {
    if (const auto readable = read_file(path, 1); !readable.ok()) return readable.error();
    const detail::GdalScope gdal;
    const auto bad = [&](ErrorCode code, const char* what) {
        return Error{code, what + gdal.because(), path};
    };
    const Dataset source(GDALOpenEx(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY,
                                    kDrivers.data(), nullptr, nullptr));
    if (!source || GDALGetRasterCount(source.get()) < 1)
        return bad(ErrorCode::BadInput,
                   "is no picture of a format that is read: GeoTIFF, PNG, JPEG, WebP, BMP, GIF, "
                   "JPEG 2000");
    Dataset picture = in_colours(source.get());
    if (!picture) return bad(ErrorCode::BadInput, "its colours can not be read");
    Dataset placed;
    if (is_placed(source.get(), terrain)) {
        placed = warped(picture.get(), *terrain, largest);
        if (!placed) return bad(ErrorCode::BadInput, "can not be brought to the raster's CRS");
    }
    GDALDatasetH from = placed ? placed.get() : picture.get();
    const Extent size = limited(GDALGetRasterXSize(from), GDALGetRasterYSize(from), largest);
    Image image(size.width, size.height, 4);
    if (!read_pixels(from, image) || gdal.failed()) return bad(ErrorCode::BadFile, "is damaged");
    return image;
}

}  // namespace relief::io
