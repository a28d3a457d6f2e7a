#include "relief/edit/geometry.h"

#include <algorithm>
#include <cmath>

namespace relief::edit {

PackedNormal packed_normal(const Vec3<double>& unit) {
    const auto packed = [](double x) {
        const double scaled = 32767 * std::clamp(x, -1.0, 1.0);
        return static_cast<std::int16_t>(scaled + std::copysign(0.5, scaled));
    };
    const bool known = std::isfinite(unit.x) && std::isfinite(unit.y) && std::isfinite(unit.z);
    if (!known) return {0, 0, 32767, 0};
    return {packed(unit.x), packed(unit.y), packed(unit.z), 0};
}

}  // namespace relief::edit
