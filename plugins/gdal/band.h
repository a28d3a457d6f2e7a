#pragma once

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "dataset.h"

/// Bands of datasets.
namespace relief::gdal {

/// One component of a dataset, or its mask. Base: GDALPamRasterBand or GDALRasterBand.
template <class Base>
class PixelBand : public Base {
  protected:
    PixelBand(Dataset& dataset, int number, int component, GDALDataType type)
        : component_(component) {
        this->poDS = &dataset;
        this->nBand = number;
        this->eAccess = GA_ReadOnly;
        this->eDataType = type;
        this->nRasterXSize = dataset.GetRasterXSize();
        this->nRasterYSize = dataset.GetRasterYSize();
        this->nBlockXSize = std::min(kBlock, this->nRasterXSize);
        this->nBlockYSize = std::min(kBlock, this->nRasterYSize);
    }

    [[nodiscard]] Dataset& dataset() const { return *static_cast<Dataset*>(this->poDS); }
    [[nodiscard]] const Pixels& pixels() const { return dataset().pixels(); }
    [[nodiscard]] const Raster& about() const { return pixels().description(); }

    /// A whole block, of which the part inside the raster is filled and the rest is 0.
    CPLErr IReadBlock(int block_col, int block_row, void* data) override {
        const LatticeBox box = block_box(block_row, block_col);
        const int size = GDALGetDataTypeSizeBytes(this->eDataType);
        const GSpacing row_size = GSpacing{size} * this->nBlockXSize;
        if (box.count() < std::int64_t{this->nBlockXSize} * this->nBlockYSize)
            std::memset(data, 0, static_cast<std::size_t>(row_size * this->nBlockYSize));
        return dataset().deliver(PixelWindow::of(box), {this->eDataType, size, row_size},
                                 {{component_, data}}, nullptr);
    }

    CPLErr IRasterIO(GDALRWFlag flag, int x, int y, int width, int height, void* data, int cols,
                     int rows, GDALDataType type, GSpacing pixel_space, GSpacing line_space,
                     GDALRasterIOExtraArg* extra) override {
        const PixelWindow window = window_of(x, y, width, height, cols, rows, *extra);
        const Way way = flag == GF_Read ? way_of(window, pixels(), extra->eResampleAlg) : Way::Gdal;
        if (way == Way::Direct)
            return dataset().deliver(window, {type, pixel_space, line_space}, {{component_, data}},
                                     extra);
        if (way == Way::Blocks && cache_blocks({y, x, height, width}) != CE_None) return CE_Failure;
        return Base::IRasterIO(flag, x, y, width, height, data, cols, rows, type, pixel_space,
                               line_space, extra);
    }

  private:
    /// The pixels of a block.
    [[nodiscard]] LatticeBox block_box(int block_row, int block_col) const {
        const LatticeBox block{std::int64_t{block_row} * this->nBlockYSize,
                               std::int64_t{block_col} * this->nBlockXSize, this->nBlockYSize,
                               this->nBlockXSize};
        return intersection(block, {0, 0, this->nRasterYSize, this->nRasterXSize});
    }

    /// Decodes the blocks of a window that GDAL's cache does not have. Windows that are too large
    /// for the cache are left to IReadBlock.
    CPLErr cache_blocks(const LatticeBox& window);
    /// Those of the box, in blocks, that it does not have, at a time.
    CPLErr cache_box(const LatticeBox& blocks);

    int component_;
};

class Band final : public PixelBand<GDALPamRasterBand> {
  public:
    Band(Dataset& dataset, int number);

    GDALColorInterp GetColorInterpretation() override;
    double GetNoDataValue(int* found) override;
    const char* GetUnitType() override;
    double GetScale(int* found) override;
    double GetOffset(int* found) override;
    double GetMinimum(int* found) override;
    double GetMaximum(int* found) override;
    int GetMaskFlags() override;
    GDALRasterBand* GetMaskBand() override;
    int HasArbitraryOverviews() override { return TRUE; }
    int GetOverviewCount() override;
    GDALRasterBand* GetOverview(int index) override;

  private:
    /// Of the samples of the original, where it is known.
    [[nodiscard]] std::optional<std::pair<double, double>> range() const;
};

/// 255: valid, 0: hole.
class MaskBand final : public PixelBand<GDALRasterBand> {
  public:
    explicit MaskBand(Dataset& dataset) : PixelBand(dataset, 0, Wanted::kMask, GDT_Byte) {}
};

}  // namespace relief::gdal
