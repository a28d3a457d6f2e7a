#include "relief/codec/raster_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

constexpr double kHole = std::numeric_limits<double>::quiet_NaN();

constexpr std::array<std::string_view, 6> kQuantities = {"value", "dx",     "dy",
                                                         "slope", "aspect", "hillshade"};

double degrees(double radians) {
    return radians * (180 / std::numbers::pi);
}

/// Of a surface that rises by gx towards the east and by gy towards the north.
double quantity_of(Quantity quantity, double gx, double gy) {
    switch (quantity) {
        case Quantity::Dx:
            return gx;
        case Quantity::Dy:
            return gy;
        case Quantity::Slope:
            return degrees(std::atan(std::hypot(gx, gy)));
        case Quantity::Aspect: {
            if (gx == 0 && gy == 0) return kHole;
            const double azimuth = degrees(std::atan2(-gx, -gy));
            return azimuth < 0 ? azimuth + 360 : azimuth;
        }
        case Quantity::Hillshade: {
            // Normal (-gx, -gy, 1) and light (-1/2, 1/2, 1/sqrt(2)).
            const double cosine =
                (0.5 * (gx - gy) + std::numbers::sqrt2 / 2) / std::sqrt(1 + gx * gx + gy * gy);
            return 1 + 254 * std::max(0.0, cosine);
        }
        case Quantity::Value:
            break;
    }
    return kHole;
}

/// Begin and count of the samples of a side of n that lie around places.
std::pair<std::int64_t, std::int64_t> around(const SampleAxis& axis, std::int64_t n) {
    const double last = static_cast<double>(n - 1);
    const double end = axis.first + axis.step * static_cast<double>(axis.count - 1);
    const auto begin = static_cast<std::int64_t>(std::floor(std::clamp(axis.first, 0.0, last)));
    const auto stop = static_cast<std::int64_t>(std::ceil(std::clamp(end, 0.0, last)));
    return {begin, stop - begin + 1};
}

/// The first of the samples of a side of n at which the places are; none if they are none.
std::optional<std::int64_t> first_sample(const SampleAxis& axis, int level, std::int64_t margin,
                                         std::int64_t n) {
    if (axis.step != std::ldexp(1.0, level)) return {};
    const double first = std::ldexp(axis.first + static_cast<double>(margin), -level);
    const bool inside = first >= 0 && first <= static_cast<double>(n - axis.count);
    if (!inside || first != std::floor(first)) return {};
    return static_cast<std::int64_t>(first);
}

double place(const SampleAxis& axis, std::int64_t k) {
    return axis.first + axis.step * static_cast<double>(k);
}

/// A mask of the places; empty: all valid.
Grid<std::uint8_t> mask_of(const RasterSurface& surface, const Sampling& places) {
    Grid<std::uint8_t> mask(places.rows.count, places.cols.count);
    bool holes = false;
    for (std::int64_t r = 0; r < mask.rows(); ++r)
        for (std::int64_t c = 0; c < mask.cols(); ++c) {
            mask(r, c) = surface.valid(place(places.rows, r), place(places.cols, c)) ? 1 : 0;
            holes = holes || mask(r, c) == 0;
        }
    return holes ? std::move(mask) : Grid<std::uint8_t>();
}

/// What has no value, as aspects of level ground, is a hole.
void mask_undefined(Raster& raster) {
    for (const Grid<double>& plane : raster.planes)
        for (std::int64_t r = 0; r < raster.rows; ++r)
            for (std::int64_t c = 0; c < raster.cols; ++c) {
                if (!std::isnan(plane(r, c))) continue;
                if (raster.mask.empty()) raster.mask = {raster.rows, raster.cols, 1};
                raster.mask(r, c) = 0;
            }
}

/// Stores the planes as the raster's type; holes become NaN.
void store(Raster& raster) {
    parallel_for(0, raster.rows, 32, [&](std::int64_t first, std::int64_t last) {
        for (Grid<double>& plane : raster.planes)
            for (std::int64_t r = first; r < last; ++r) {
                stored_row(plane.row(r), raster.cols, raster.type, raster.nodata, plane.row(r));
                if (raster.mask.empty()) continue;
                for (std::int64_t c = 0; c < raster.cols; ++c)
                    if (!raster.valid(r, c)) plane(r, c) = kHole;
            }
    });
}

Raster described(const RasterFile& file, const Sampling& sampling) {
    Raster raster = description_of(file.description());
    raster.rows = sampling.rows.count;
    raster.cols = sampling.cols.count;
    raster.geo = georeference_of(raster.geo, sampling);
    return raster;
}

/// Gradients of a surface on rows of places.
class GradientRows {
  public:
    GradientRows(const RasterSurface& surface, const Sampling& places)
        : surface_(surface), places_(places) {}

    /// Of rows first .. first + count - 1. Errors: as RasterSurface::evaluate.
    Status evaluate(int component, std::int64_t first, std::int64_t count) {
        const auto size = static_cast<std::size_t>(count * places_.cols.count);
        for (auto* numbers : {&i_, &j_, &value_, &di_, &dj_}) numbers->resize(size);
        std::size_t at = 0;
        for (std::int64_t r = first; r < first + count; ++r)
            for (std::int64_t c = 0; c < places_.cols.count; ++c, ++at) {
                i_[at] = place(places_.rows, r);
                j_[at] = place(places_.cols, c);
            }
        return surface_.evaluate(component, i_, j_, 1, {value_, di_, dj_, {}, {}, {}});
    }
    [[nodiscard]] double di(std::size_t at) const { return di_[at]; }
    [[nodiscard]] double dj(std::size_t at) const { return dj_[at]; }

  private:
    const RasterSurface& surface_;
    const Sampling& places_;
    std::vector<double> i_, j_, value_, di_, dj_;
};

}  // namespace

std::string_view quantity_name(Quantity quantity) {
    return kQuantities[static_cast<std::size_t>(quantity)];
}

Result<Quantity> quantity_from_name(std::string_view name) {
    const auto found = std::find(kQuantities.begin(), kQuantities.end(), name);
    if (found != kQuantities.end()) return static_cast<Quantity>(found - kQuantities.begin());
    std::string known;
    for (const std::string_view quantity : kQuantities)
        known += (known.empty() ? "" : ", ") + std::string(quantity);
    return Error{ErrorCode::InvalidArgument,
                 "nothing is called '" + std::string(name) + "'; choose one of " + known, ""};
}

int RasterSampler::level_for(const Sampling& sampling) const {
    const Raster& about = file_.description();
    const auto serves = [](std::int64_t have, std::int64_t n, double step) {
        return static_cast<double>(have) * step >= static_cast<double>(n);
    };
    int level = 0;
    while (level < file_.layout().levels()) {
        const std::int64_t below = (std::int64_t{1} << (level + 1)) - 1;
        if (!serves((about.rows + below) >> (level + 1), about.rows, sampling.rows.step) ||
            !serves((about.cols + below) >> (level + 1), about.cols, sampling.cols.step))
            break;
        ++level;
    }
    return level;
}

std::optional<RasterSampler::Window> RasterSampler::samples_at(const Sampling& sampling) const {
    const int level = std::ilogb(sampling.rows.step);
    if (level < 0 || level > file_.layout().levels()) return {};
    const LatticeMargin margin = level == 0 ? LatticeMargin() : file_.margin();
    const LatticeBox all = file_.box(level);
    const auto row = first_sample(sampling.rows, level, margin.rows, all.rows);
    const auto col = first_sample(sampling.cols, level, margin.cols, all.cols);
    if (!row || !col) return {};
    return Window{level, {*row, *col, sampling.rows.count, sampling.cols.count}};
}

Result<Raster> RasterSampler::decode(const Window& window) {
    if (file_.decodes_parts()) {
        RELIEF_TRY(DecodedRaster decoded, file_.decode_window(window.level, window.box));
        RELIEF_CHECK(check_damage(decoded.damaged));
        return std::move(decoded.raster);
    }
    if (!whole_ || whole_->level != window.level) {
        whole_.reset();
        RELIEF_TRY(Raster raster, file_.decode(window.level));
        whole_ = {window.level, std::move(raster)};
    }
    return MemoryRaster(whole_->raster).read(window.box);
}

Result<const RasterSurface*> RasterSampler::surface_at(int level, Sampling& places) {
    const LatticeMargin margin = level == 0 ? LatticeMargin() : file_.margin();
    const auto to_level = [level](SampleAxis& axis, std::int64_t before) {
        axis.first = std::ldexp(axis.first + static_cast<double>(before), -level);
        axis.step = std::ldexp(axis.step, -level);
    };
    to_level(places.rows, margin.rows);
    to_level(places.cols, margin.cols);
    const LatticeBox all = file_.box(level);
    const auto [row0, rows] = around(places.rows, all.rows);
    const auto [col0, cols] = around(places.cols, all.cols);
    return surfaces_.around(level, {row0, col0, rows, cols});
}

Result<Raster> RasterSampler::values(const Sampling& sampling, SampleType type) {
    Raster result = described(file_, sampling);
    if (const auto window = samples_at(sampling)) {
        RELIEF_TRY(Raster samples, decode(*window));
        result.planes = std::move(samples.planes);
        result.mask = std::move(samples.mask);
        return result;
    }
    result.type = type;
    Sampling places = sampling;
    RELIEF_TRY(const RasterSurface* surface, surface_at(level_for(sampling), places));
    for (int c = 0; c < surface->components(); ++c) {
        Grid<double>& plane = result.planes.emplace_back(result.rows, result.cols);
        surface->evaluate_grid(c, places.rows.first, places.rows.step, places.cols.first,
                               places.cols.step, plane.view());
    }
    if (file_.has_holes()) result.mask = mask_of(*surface, places);
    store(result);
    return result;
}

Result<Raster> RasterSampler::derived(Quantity quantity, const Sampling& sampling,
                                      const PlaceMap& ground) {
    const int level = level_for(sampling);
    Sampling places = sampling;
    RELIEF_TRY(const RasterSurface* surface, surface_at(level, places));
    const double scale = std::ldexp(file_.description().scale, -level);
    Raster result = described(file_, sampling);
    result.type = quantity == Quantity::Hillshade ? SampleType::UInt8 : SampleType::Float32;
    result.nodata = quantity == Quantity::Hillshade ? 0 : kHole;
    const std::int64_t strip = std::max<std::int64_t>(1, (std::int64_t{1} << 18) / result.cols);
    GradientRows gradients(*surface, places);
    for (int component = 0; component < surface->components(); ++component) {
        Grid<double>& plane = result.planes.emplace_back(result.rows, result.cols);
        for (std::int64_t row = 0; row < result.rows; row += strip) {
            const std::int64_t count = std::min(strip, result.rows - row);
            RELIEF_CHECK(gradients.evaluate(component, row, count));
            parallel_for(0, count, 16, [&](std::int64_t first, std::int64_t last) {
                auto at = static_cast<std::size_t>(first * result.cols);
                for (std::int64_t r = first; r < last; ++r)
                    for (std::int64_t c = 0; c < result.cols; ++c, ++at) {
                        const auto [gx, gy] =
                            ground.gradient(scale * gradients.di(at), scale * gradients.dj(at));
                        plane(row + r, c) = quantity_of(quantity, gx, gy);
                    }
            });
        }
    }
    if (file_.has_holes()) result.mask = mask_of(*surface, places);
    if (quantity == Quantity::Aspect) mask_undefined(result);
    store(result);
    return result;
}

}  // namespace relief::codec
