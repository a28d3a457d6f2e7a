#include "band.h"

#include <vector>

#include "relief/io/gdal.h"
#include "report.h"

namespace relief::gdal {

namespace {

/// Blocks a side that are decoded at a time.
constexpr std::int64_t kSide = 8;

/// What a user has set, which GDAL keeps beside the file, or else what the file says.
template <class Get>
double kept_or(Get get, std::optional<double> own, double otherwise, int* found) {
    int kept = FALSE;
    const double value = get(&kept);
    if (found) *found = kept || own ? TRUE : FALSE;
    return kept ? value : own.value_or(otherwise);
}

}  // namespace

template <class Base>
CPLErr PixelBand<Base>::cache_blocks(const LatticeBox& window) {
    const std::int64_t row0 = window.row0 / this->nBlockYSize;
    const std::int64_t col0 = window.col0 / this->nBlockXSize;
    const LatticeBox met{row0, col0, (window.row0 + window.rows - 1) / this->nBlockYSize + 1 - row0,
                         (window.col0 + window.cols - 1) / this->nBlockXSize + 1 - col0};
    const std::int64_t block_bytes = std::int64_t{GDALGetDataTypeSizeBytes(this->eDataType)} *
                                     this->nBlockXSize * this->nBlockYSize;
    if (met.count() > GDALGetCacheMax64() / 2 / block_bytes) return CE_None;
    const auto cut = [](std::int64_t first, std::int64_t end) {
        return std::min<std::int64_t>(kSide, end - first);
    };
    const std::int64_t end_row = met.row0 + met.rows;
    const std::int64_t end_col = met.col0 + met.cols;
    for (std::int64_t row = met.row0; row < end_row; row += kSide)
        for (std::int64_t col = met.col0; col < end_col; col += kSide)
            if (cache_box({row, col, cut(row, end_row), cut(col, end_col)}) != CE_None)
                return CE_Failure;
    return CE_None;
}

template <class Base>
CPLErr PixelBand<Base>::cache_box(const LatticeBox& blocks) {
    std::vector<std::pair<int, int>> missing;  // row and column
    for (std::int64_t k = 0; k < blocks.count(); ++k) {
        const int row = static_cast<int>(blocks.row0 + k / blocks.cols);
        const int col = static_cast<int>(blocks.col0 + k % blocks.cols);
        if (GDALRasterBlock* block = this->TryGetLockedBlockRef(col, row))
            block->DropLock();
        else
            missing.emplace_back(row, col);
    }
    if (missing.empty()) return CE_None;
    const auto [left, right] =
        std::minmax_element(missing.begin(), missing.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; });
    const LatticeBox first = block_box(missing.front().first, left->second);
    const LatticeBox last = block_box(missing.back().first, right->second);
    const LatticeBox all{first.row0, first.col0, last.row0 + last.rows - first.row0,
                         last.col0 + last.cols - first.col0};
    return guarded(CE_Failure, [&] {
        const auto raster = dataset().pixels().read(PixelWindow::of(all), about().type);
        if (!raster.ok()) {
            report(raster.error(), dataset().GetDescription());
            return CE_Failure;
        }
        const int size = GDALGetDataTypeSizeBytes(this->eDataType);
        for (const auto& [row, col] : missing) {
            GDALRasterBlock* block = this->GetLockedBlockRef(col, row, TRUE);
            if (!block) return CE_Failure;
            store(**raster, relative(block_box(row, col), all.row0, all.col0), pixels().holes(),
                  {component_, block->GetDataRef()},
                  {this->eDataType, size, GSpacing{size} * this->nBlockXSize});
            block->DropLock();
        }
        return CE_None;
    });
}

template class PixelBand<GDALPamRasterBand>;
template class PixelBand<GDALRasterBand>;

Band::Band(Dataset& owner, int number)
    : PixelBand(owner, number, number - 1, io::gdal_type(owner.pixels().description().type)) {
    const auto& names = about().band_names;
    // GDALPamRasterBand's would note it as a change to be kept beside the file.
    if (!names.empty())
        GDALRasterBand::SetDescription(names[static_cast<std::size_t>(number - 1)].c_str());
}

GDALColorInterp Band::GetColorInterpretation() {
    const GDALColorInterp kept = GDALPamRasterBand::GetColorInterpretation();
    return kept == GCI_Undefined && nBand == 1 ? GCI_GrayIndex : kept;
}

double Band::GetNoDataValue(int* found) {
    return kept_or([&](int* kept) { return GDALPamRasterBand::GetNoDataValue(kept); },
                   pixels().holes().nodata, 0, found);
}

const char* Band::GetUnitType() {
    const char* kept = GDALPamRasterBand::GetUnitType();
    return kept && *kept ? kept : about().unit.c_str();
}

double Band::GetScale(int* found) {
    return kept_or([&](int* kept) { return GDALPamRasterBand::GetScale(kept); },
                   about().scale == 1 ? std::nullopt : std::optional(about().scale), 1, found);
}

double Band::GetOffset(int* found) {
    return kept_or([&](int* kept) { return GDALPamRasterBand::GetOffset(kept); },
                   about().offset == 0 ? std::nullopt : std::optional(about().offset), 0, found);
}

std::optional<std::pair<double, double>> Band::range() const {
    const bool whole = pixels().quantity() == codec::Quantity::Value &&
                       pixels().places().rows.step == 1 && pixels().places().cols.step == 1;
    return whole ? pixels().file().original_range(nBand - 1) : std::nullopt;
}

double Band::GetMinimum(int* found) {
    const auto known = range();
    return kept_or([&](int* kept) { return GDALPamRasterBand::GetMinimum(kept); },
                   known ? std::optional(known->first) : std::nullopt,
                   sample_range(about().type).first, found);
}

double Band::GetMaximum(int* found) {
    const auto known = range();
    return kept_or([&](int* kept) { return GDALPamRasterBand::GetMaximum(kept); },
                   known ? std::optional(known->second) : std::nullopt,
                   sample_range(about().type).second, found);
}

int Band::GetMaskFlags() {
    return pixels().holes().mask_band ? GMF_PER_DATASET : GDALPamRasterBand::GetMaskFlags();
}

GDALRasterBand* Band::GetMaskBand() {
    return pixels().holes().mask_band ? &dataset().mask() : GDALPamRasterBand::GetMaskBand();
}

int Band::GetOverviewCount() {
    const int kept = GDALPamRasterBand::GetOverviewCount();
    return kept > 0 ? kept : static_cast<int>(dataset().overviews().size());
}

GDALRasterBand* Band::GetOverview(int index) {
    if (GDALPamRasterBand::GetOverviewCount() > 0) return GDALPamRasterBand::GetOverview(index);
    const auto& overviews = dataset().overviews();
    if (index < 0 || index >= static_cast<int>(overviews.size())) return nullptr;
    return overviews[static_cast<std::size_t>(index)]->GetRasterBand(nBand);
}

}  // namespace relief::gdal
