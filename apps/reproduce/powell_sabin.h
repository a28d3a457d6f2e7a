#pragma once

#include "relief/multires/ps_space.h"
#include "reproduce.h"

/// What rows and figures of Powell-Sabin splines share.
namespace relief::reproduce::ps_text {

namespace ps = multires::ps;

/// side x side squares over the unit square, each cut along its diagonal that rises.
[[nodiscard]] ps::Space squares(int side);
/// Random sites and the corners of the unit square.
[[nodiscard]] ps::Space random_space(int sites, unsigned seed);
/// The spline with the values and gradients of Franke's function at the vertices.
[[nodiscard]] ps::Coefficients franke_spline(const ps::Space& space);

/// Sections 2 and 3: B-splines, refinement, where the text needs care.
void add_refinement(Rows& rows);
/// Section 4: wavelets by lifting.
void add_wavelets(Rows& rows);

/// The largest over the smallest eigenvalue of the Gram matrix of these splines of a space, each
/// scaled to norm 1.
[[nodiscard]] double scaled_condition(const ps::Space& space,
                                      const std::vector<ps::Coefficients>& splines);
/// All B-splines of a space.
[[nodiscard]] std::vector<ps::Coefficients> all_b_splines(const ps::Space& space);

}  // namespace relief::reproduce::ps_text
