#pragma once

#include <vector>

#include "relief/multires/mesh_hierarchy.h"

/// Details of a surface whose coarse vertices move: they turn with it, and grow as it does. Source:
/// reverse-subdivision.md section 11.
namespace relief::multires {

/// A detail in a frame of the surface that it was made for, and the size of that frame.
struct LocalDetail {
    Vec3<double> offset;
    double size = 0;  ///< MeshFrame::size

    /// What it is on a surface with another frame there, in the coordinates' frame.
    [[nodiscard]] Vec3<double> turned(const MeshFrame& now) const {
        const bool known = size > 0 && now.size > 0;
        const double growth = known ? now.size / size : 1;
        return growth * now.out(offset);
    }
};

/// Those of a step: of its new vertices and of its stiff ones.
struct LocalDetails {
    std::vector<LocalDetail> fresh;
    std::vector<LocalDetail> stiff;
};

/// The same in the coordinates' frame.
struct GlobalDetails {
    std::vector<Vec3<double>> fresh;
    std::vector<Vec3<double>> stiff;
};

/// Requires: frames of the same step. Complexity: O(n).
[[nodiscard]] GlobalDetails turned(const LocalDetails& details, const DetailFrames& now);

}  // namespace relief::multires
