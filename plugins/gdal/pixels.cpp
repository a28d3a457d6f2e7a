#include "pixels.h"

#include <cmath>
#include <limits>

#include "relief/io/raster.h"

namespace relief::gdal {

namespace {

/// From places on the ground, in the unit of the physical heights.
Result<PlaceMap> ground_of(const Raster& about) {
    GeoReference ground = about.geo;
    if (ground.transform) {
        const io::CellSize scale = io::ground_scale(about);
        auto& t = *ground.transform;
        for (const std::size_t k : {0U, 1U, 2U}) t[k] *= scale.x;
        for (const std::size_t k : {3U, 4U, 5U}) t[k] *= scale.y;
    }
    return PlaceMap::create(ground);
}

bool holds(SampleType type, double nodata) {
    if (std::isnan(nodata)) return !is_integer(type);
    return stored_value(nodata, type, {}) == nodata;
}

HoleCode holes_of(const Raster& about, bool has_holes) {
    if (about.nodata && holds(about.type, *about.nodata)) return {about.nodata, false};
    if (!has_holes) return {};
    if (is_integer(about.type)) return {{}, true};
    return {std::numeric_limits<double>::quiet_NaN(), false};
}

}  // namespace

PixelWindow PixelWindow::of(const LatticeBox& box) {
    const auto number = [](std::int64_t k) { return static_cast<double>(k); };
    return {number(box.col0), number(box.row0), number(box.cols),
            number(box.rows), box.cols,         box.rows};
}

PixelWindow PixelWindow::part(const LatticeBox& box) const {
    const double per_col = width / static_cast<double>(cols);
    const double per_row = height / static_cast<double>(rows);
    return {x + per_col * static_cast<double>(box.col0),
            y + per_row * static_cast<double>(box.row0),
            per_col * static_cast<double>(box.cols),
            per_row * static_cast<double>(box.rows),
            box.cols,
            box.rows};
}

Result<Pixels> Pixels::create(std::shared_ptr<OpenFile> file, codec::Quantity quantity,
                              const Sampling& places) {
    Pixels pixels;
    pixels.file_ = std::move(file);
    pixels.quantity_ = quantity;
    pixels.places_ = places;
    const Raster& whole = pixels.file().description();
    Raster& about = pixels.description_;
    about = description_of(whole);
    about.rows = places.rows.count;
    about.cols = places.cols.count;
    about.geo = georeference_of(about.geo, places);
    pixels.holes_ = holes_of(about, pixels.file().has_holes());
    if (quantity == codec::Quantity::Value) return pixels;

    using codec::Quantity;
    if (quantity == Quantity::Dx || quantity == Quantity::Dy) {
        RELIEF_TRY(pixels.ground_, PlaceMap::create(whole.geo));
    } else {
        RELIEF_TRY(pixels.ground_, ground_of(whole));
    }
    const bool shade = quantity == Quantity::Hillshade;
    about.type = shade ? SampleType::UInt8 : SampleType::Float32;
    about.nodata = shade ? 0 : std::numeric_limits<double>::quiet_NaN();
    about.scale = 1;
    about.offset = 0;
    about.unit = quantity == Quantity::Slope || quantity == Quantity::Aspect ? "degree" : "";
    about.band_names.assign(static_cast<std::size_t>(pixels.components()),
                            std::string(codec::quantity_name(quantity)));
    pixels.holes_ = {about.nodata, false};
    return pixels;
}

Result<const Raster*> Pixels::read(const PixelWindow& window, SampleType type) {
    const Sampling places{places_.rows.cut(window.y, window.height, window.rows),
                          places_.cols.cut(window.x, window.width, window.cols)};
    if (last_ && last_->places == places && last_->type == type) return &last_->raster;
    last_.reset();
    const bool value = quantity_ == codec::Quantity::Value;
    RELIEF_TRY(Raster raster, value ? file_->sampler.values(places, type)
                                    : file_->sampler.derived(quantity_, places, ground_));
    last_ = {places, type, std::move(raster)};
    return &last_->raster;
}

}  // namespace relief::gdal
