#pragma once

#include "relief/multires/subdivider.h"

/// The sparse part of forward subdivision: boundaries, creases, corners.
namespace relief::multires {

[[nodiscard]] SharpFeatures sharp_features(const mesh::Topology& mesh, const Sharpness& sharpness);
void add_boundary(const mesh::Topology& mesh, SharpFeatures& features);

/// Those of the finer mesh; of sqrt(3) without the boundary.
[[nodiscard]] SharpFeatures refined(const SharpFeatures& features, const mesh::Topology& coarse,
                                    mesh::Split split);

/// Sets the masks, and which faces are trisected. Complexity: O(n log n) for n features.
void set_masks(const mesh::Topology& coarse, const SharpFeatures& features, mesh::Split split,
               ForwardRules& rules);

}  // namespace relief::multires
