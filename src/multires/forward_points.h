#pragma once

#include "relief/multires/subdivider.h"

namespace relief::multires {

/// One step in place: the points of a coarse mesh become those of the finer one; the array has room
/// for these. sums: 4 scalars for each coarse vertex, aligned to 4 of them. T: float or double.
template <class T>
void forward_points(const mesh::Topology& coarse, mesh::Split split, const ForwardRules& rules,
                    Vec3<T>* points, T* sums);

}  // namespace relief::multires
