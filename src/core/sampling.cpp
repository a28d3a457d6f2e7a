#include "relief/core/sampling.h"

#include <cmath>

namespace relief {

GeoReference georeference_of(GeoReference geo, const Sampling& sampling) {
    if (!geo.transform) return geo;
    auto& t = *geo.transform;
    // Centre of the first sample, then half a new cell back.
    const auto corner = [](const SampleAxis& axis) { return axis.first + 0.5 * (1 - axis.step); };
    const double col = corner(sampling.cols);
    const double row = corner(sampling.rows);
    t[0] += col * t[1] + row * t[2];
    t[3] += col * t[4] + row * t[5];
    for (const std::size_t k : {1U, 4U}) t[k] *= sampling.cols.step;
    for (const std::size_t k : {2U, 5U}) t[k] *= sampling.rows.step;
    return geo;
}

Result<PlaceMap> PlaceMap::create(const GeoReference& geo) {
    // Sample (i, j) has its centre at column j + 1/2, row i + 1/2 of the transform.
    const std::array<double, 6> t =
        geo.transform.value_or(std::array<double, 6>{-0.5, 1, 0, -0.5, 0, 1});
    const double determinant = t[1] * t[5] - t[2] * t[4];
    PlaceMap map;
    map.x0_ = t[0] + 0.5 * t[1] + 0.5 * t[2];
    map.y0_ = t[3] + 0.5 * t[4] + 0.5 * t[5];
    map.jx_ = t[5] / determinant;
    map.jy_ = -t[2] / determinant;
    map.ix_ = -t[4] / determinant;
    map.iy_ = t[1] / determinant;
    if (std::isfinite(map.jx_) && std::isfinite(map.jy_) && std::isfinite(map.ix_) &&
        std::isfinite(map.iy_))
        return map;
    return Error{ErrorCode::BadInput,
                 "its transform gives different samples the same place; correct it: "
                 "gdal_edit.py -a_ullr",
                 ""};
}

}  // namespace relief
