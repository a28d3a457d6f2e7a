#pragma once

#include <gdal_pam.h>

#include <memory>
#include <string>
#include <vector>

#include "pixels.h"

/// A .relief raster, or a level or derived raster of it, as GDAL's dataset.
namespace relief::gdal {

/// Blocks of bands: a tile of the closed loop gives one.
inline constexpr int kBlock = 512;

/// Where GDAL wants pixels: of type `type`, `pixel_space` bytes apart in a row, rows `line_space`
/// bytes apart.
struct PixelBuffer {
    GDALDataType type = GDT_Float64;
    GSpacing pixel_space = 8;
    GSpacing line_space = 8;
};

/// One component, or the mask, and where its pixels go.
struct Wanted {
    static constexpr int kMask = -1;
    int component = 0;
    void* data = nullptr;
};

class Dataset final : public GDALPamDataset {
  public:
    static int identify(GDALOpenInfo* info);
    static GDALDataset* open(GDALOpenInfo* info);

    explicit Dataset(Pixels pixels);
    ~Dataset() override;

    CPLErr GetGeoTransform(double* transform) override;
    const OGRSpatialReference* GetSpatialRef() const override;
    char** GetMetadataDomainList() override;
    char** GetMetadata(const char* domain) override;

    [[nodiscard]] Pixels& pixels() { return pixels_; }
    /// Those of the next coarser level, and so on.
    [[nodiscard]] const std::vector<std::unique_ptr<Dataset>>& overviews() const {
        return overviews_;
    }
    /// The mask that all bands share.
    [[nodiscard]] GDALRasterBand& mask() { return *mask_; }

    /// Reads a window past GDAL's blocks, piece by piece.
    CPLErr deliver(const PixelWindow& window, const PixelBuffer& buffer,
                   const std::vector<Wanted>& wanted, GDALRasterIOExtraArg* extra);

  protected:
    CPLErr IRasterIO(GDALRWFlag flag, int x, int y, int width, int height, void* data, int cols,
                     int rows, GDALDataType type, int count, int* bands, GSpacing pixel_space,
                     GSpacing line_space, GSpacing band_space,
                     GDALRasterIOExtraArg* extra) override;
    /// Overviews of the user's, in a file beside, take the place of the levels.
    CPLErr IBuildOverviews(const char* resampling, int count, const int* factors, int band_count,
                           const int* bands, GDALProgressFunc progress, void* progress_data,
                           CSLConstList options) override;

  private:
    CPLErr deliver_piece(const PixelWindow& window, const LatticeBox& piece,
                         const PixelBuffer& buffer, const std::vector<Wanted>& wanted);
    /// What GDAL is told of the file.
    void describe(const OpenOptions& options);
    /// The levels beyond `level`.
    void add_overviews(int level);

    Pixels pixels_;
    OGRSpatialReference reference_;
    std::unique_ptr<GDALRasterBand> mask_;
    std::vector<std::unique_ptr<Dataset>> overviews_;
    CPLStringList derived_;  ///< names of derived rasters
};

/// How a read is served.
enum class Way {
    Direct,  ///< decoded for this read alone
    Blocks,  ///< through GDAL's cache: more is decoded than is asked for
    Gdal,    ///< by GDAL's own resampling
};
[[nodiscard]] Way way_of(const PixelWindow& window, const Pixels& pixels,
                         GDALRIOResampleAlg resampling);

/// The window that GDAL asks for.
[[nodiscard]] PixelWindow window_of(int x, int y, int width, int height, int cols, int rows,
                                    const GDALRasterIOExtraArg& extra);

/// A part of a component, or of the mask, as GDAL wants it.
void store(const Raster& raster, const LatticeBox& part, const HoleCode& holes,
           const Wanted& wanted, const PixelBuffer& buffer);

}  // namespace relief::gdal
