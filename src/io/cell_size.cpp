#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "io/gdal_scope.h"
#include "io/spatial_reference.h"

namespace relief::io {

namespace {

struct Crs {
    bool geographic = false;
    double unit = 1;  ///< metres, or radians when geographic
};

Crs parse_crs(const std::string& text) {
    const SpatialReference crs = reference_of(text);
    if (!crs) return {};
    if (OSRIsGeographic(crs.get())) return {true, OSRGetAngularUnits(crs.get(), nullptr)};
    return {false, OSRGetLinearUnits(crs.get(), nullptr)};
}

/// Metres a radian of longitude and of latitude at latitude `phi`: the radius of the parallel
/// circle and the meridian radius of curvature of the WGS 84 ellipsoid.
CellSize radii(double phi) {
    constexpr double a = 6378137.0;
    constexpr double f = 1 / 298.257223563;
    constexpr double e2 = f * (2 - f);
    const double w2 = 1 - e2 * std::sin(phi) * std::sin(phi);
    return {a * std::cos(phi) / std::sqrt(w2), a * (1 - e2) / (w2 * std::sqrt(w2))};
}

double metres_of(const std::string& unit) {
    constexpr std::array<std::string_view, 3> feet = {"ft", "foot", "feet"};
    constexpr std::array<std::string_view, 4> survey_feet = {"US survey foot", "ftUS", "us-ft",
                                                             "Foot_US"};
    if (std::find(feet.begin(), feet.end(), unit) != feet.end()) return 0.3048;
    if (std::find(survey_feet.begin(), survey_feet.end(), unit) != survey_feet.end())
        return 1200.0 / 3937;
    return 1;
}

/// Metres a unit of x and of y at the middle row.
CellSize metres_of_units(const GeoReference& geo, std::int64_t rows) {
    const detail::GdalScope gdal;
    const Crs crs = parse_crs(geo.crs);
    if (!crs.geographic) return {crs.unit, crs.unit};
    const std::array<double, 6>& t = *geo.transform;
    const double middle = t[3] + t[5] * static_cast<double>(rows) / 2;
    constexpr double limit = 89.0 * std::numbers::pi / 180;  // cells shrink to nothing at the poles
    const CellSize radius = radii(std::clamp(middle * crs.unit, -limit, limit));
    return {crs.unit * radius.x, crs.unit * radius.y};
}

}  // namespace

CellSize cell_size_metres(const GeoReference& geo, std::int64_t rows) {
    if (!geo.transform) return {};
    const std::array<double, 6>& t = *geo.transform;
    const CellSize scale = metres_of_units(geo, rows);
    const CellSize cell{std::hypot(t[1] * scale.x, t[4] * scale.y),
                        std::hypot(t[2] * scale.x, t[5] * scale.y)};
    return cell.x > 0 && cell.y > 0 ? cell : CellSize{};
}

CellSize ground_scale(const Raster& about) {
    if (about.geo.crs.empty() || !about.geo.transform) return {};
    const CellSize metres = metres_of_units(about.geo, about.rows);
    const double unit = metres_of(about.unit);
    return {metres.x / unit, metres.y / unit};
}

std::optional<CellSize> cell_size_in_unit(const Raster& about) {
    if (about.geo.crs.empty() || !about.geo.transform) return {};
    const CellSize cell = cell_size_metres(about.geo, about.rows);
    const double unit = metres_of(about.unit);
    return CellSize{cell.x / unit, cell.y / unit};
}

}  // namespace relief::io
