#pragma once

#include "relief/spline/fvs_element.h"

/// Functions that the papers interpolate.
namespace relief::reproduce {

/// Franke's: three hills and a hollow over the unit square, with its gradient; the Hessian is 0.
[[nodiscard]] spline::PlaneJet franke(Vec2 p);

}  // namespace relief::reproduce
