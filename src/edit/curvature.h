#pragma once

#include "relief/core/vec3.h"

namespace relief::edit {

/// Requires: v is not zero.
[[nodiscard]] inline Vec3<double> unit(const Vec3<double>& v) {
    return (1 / length(v)) * v;
}

/// First and second derivatives of a surface in space along two parameters.
struct SurfaceDerivatives {
    Vec3<double> u, v, uu, uv, vv;
};

/// Positive where the surface is a valley seen from its normal's side.
[[nodiscard]] inline double mean_curvature(const SurfaceDerivatives& d,
                                           const Vec3<double>& normal) {
    const double e = dot(d.u, d.u), f = dot(d.u, d.v), g = dot(d.v, d.v);
    const double l = dot(d.uu, normal), m = dot(d.uv, normal), n = dot(d.vv, normal);
    return (e * n - 2 * f * m + g * l) / (2 * (e * g - f * f));
}

}  // namespace relief::edit
