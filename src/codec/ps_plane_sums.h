#pragma once

#include "relief/core/vec2.h"
#include "relief/spline/ps_element.h"

namespace relief::codec {

/// Sums over points near an origin with weights 1 / distance^2, of which the nearest plane by least
/// squares follows. docs/format.md, "Nearest planes".
struct PlaneSums {
    double count = 0;
    double weight = 0;
    double value = 0;
    Vec2 first;  ///< of offsets
    double xx = 0;
    double xy = 0;
    double yy = 0;
    Vec2 moment;  ///< of offsets x values

    /// Requires: offset is not 0.
    void add(Vec2 offset, double z) {
        const double w = 1 / dot(offset, offset);
        count += 1;
        weight += w;
        value += w * z;
        first = first + w * offset;
        xx += w * (offset.x * offset.x);
        xy += w * (offset.x * offset.y);
        yy += w * (offset.y * offset.y);
        moment = moment + (w * z) * offset;
    }

    [[nodiscard]] double mean() const { return value / weight; }

    /// The plane at the origin whose gradient is held near `expected`: trust > 0 is what a
    /// difference there counts, for each point, against a relative difference of values.
    [[nodiscard]] spline::TangentPlane plane(Vec2 expected, double trust) const {
        const Vec2 centre = {first.x / weight, first.y / weight};
        const double hold = trust * count;
        const double cxx = xx - first.x * centre.x + hold;
        const double cxy = xy - first.x * centre.y;
        const double cyy = yy - first.y * centre.y + hold;
        const double mx = moment.x - value * centre.x + hold * expected.x;
        const double my = moment.y - value * centre.y + hold * expected.y;
        const double determinant = cxx * cyy - cxy * cxy;
        const Vec2 g = {(mx * cyy - my * cxy) / determinant, (my * cxx - mx * cxy) / determinant};
        return {mean() - dot(g, centre), g};
    }
};

}  // namespace relief::codec
