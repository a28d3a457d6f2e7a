#pragma once

#include "relief/multires/mesh_step.h"

/// Catmull-Clark details with the residuals of stiff vertices inside them: as many vectors as the
/// fine mesh has vertices. Source: reverse-subdivision.md section 5.3.
///
/// With s_e(d) = 4 d_E - d_F - d_F' for an edge between two faces, and 2 d_E for a sharp one, the
/// details of a step satisfy (sum of s_e(d) over the edges at v) = 0 at every stiff vertex v. So
/// there is room for its residual r_v in the details of its edges, from which that sum tells it.
namespace relief::multires {

/// Errors: BadInput `not_reversible` if the step has components of which subdivision loses the
/// alternating sum: their residuals say more than the details have room for.
[[nodiscard]] Status check_packed(const StepRules& rules);

/// details += the residuals, spread over the edges at each stiff vertex. Requires: details of
/// MeshStep::analyse, in the coordinates' frame; check_packed. Complexity: O(n).
void pack_residuals(const MeshStep<double>& step, const Vec3<double>* residuals,
                    Vec3<double>* details);

/// The reverse: residuals, one for each stiff vertex, are taken out of the details. Complexity:
/// O(n), and for clusters of k stiff vertices O(k) for each of at most O(sqrt(k)) rounds.
void unpack_residuals(const MeshStep<double>& step, Vec3<double>* details, Vec3<double>* residuals);

}  // namespace relief::multires
