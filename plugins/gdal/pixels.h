#pragma once

#include <memory>
#include <optional>

#include "open_options.h"
#include "relief/codec/raster_sampler.h"

/// What the bands of a dataset have in common: where their pixels lie and what they show.
namespace relief::gdal {

/// An open file, behind the datasets of all its levels. For one thread at a time.
struct OpenFile {
    explicit OpenFile(codec::RasterFile opened) : file(std::move(opened)), sampler(file) {}
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;

    codec::RasterFile file;
    codec::RasterSampler sampler;
};

/// How holes look to GDAL.
struct HoleCode {
    std::optional<double> nodata = {};  ///< the value of pixels in holes
    bool mask_band = false;             ///< no value is left for them
};

/// A window of a dataset's pixels, and how many are wanted of it.
struct PixelWindow {
    double x = 0;
    double y = 0;
    double width = 0;
    double height = 0;
    std::int64_t cols = 0;
    std::int64_t rows = 0;

    [[nodiscard]] static PixelWindow of(const LatticeBox& box);
    /// Neither more pixels are wanted nor less.
    [[nodiscard]] bool unscaled() const {
        return width == static_cast<double>(cols) && height == static_cast<double>(rows);
    }
    /// Of the wanted ones those in a box.
    [[nodiscard]] PixelWindow part(const LatticeBox& box) const;
};

class Pixels {
  public:
    /// Errors: BadInput if slopes are wanted of a raster whose transform makes no sense.
    [[nodiscard]] static Result<Pixels> create(std::shared_ptr<OpenFile> file,
                                               codec::Quantity quantity, const Sampling& places);

    [[nodiscard]] const codec::RasterFile& file() const { return file_->file; }
    [[nodiscard]] const std::shared_ptr<OpenFile>& shared_file() const { return file_; }
    [[nodiscard]] codec::Quantity quantity() const { return quantity_; }
    [[nodiscard]] const Sampling& places() const { return places_; }
    /// The raster that all pixels are, without samples.
    [[nodiscard]] const Raster& description() const { return description_; }
    [[nodiscard]] int components() const { return file().layout().components; }
    [[nodiscard]] const HoleCode& holes() const { return holes_; }
    /// The sampler keeps all of it. Of others, reading a part decodes the tiles around it.
    [[nodiscard]] bool kept_whole() const {
        return quantity_ == codec::Quantity::Value ? !file().decodes_parts()
                                                   : !file().closed_loop();
    }

    /// Pixels of a window; between samples values are as `type` stores them. What is returned is
    /// kept until the next call, and given again if the same is asked for. Errors: BadFile.
    [[nodiscard]] Result<const Raster*> read(const PixelWindow& window, SampleType type);

    /// Keeps nothing.
    void forget() { last_.reset(); }

  private:
    Pixels() = default;

    struct Last {
        Sampling places;
        SampleType type;
        Raster raster;
    };

    std::shared_ptr<OpenFile> file_;
    codec::Quantity quantity_ = codec::Quantity::Value;
    Sampling places_;
    PlaceMap ground_;
    Raster description_;
    HoleCode holes_;
    std::optional<Last> last_;
};

}  // namespace relief::gdal
