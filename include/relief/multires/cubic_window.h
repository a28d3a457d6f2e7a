#pragma once

#include <array>
#include <vector>

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/multires/pyramid.h"

/// Scheme `cubic` on windows of a raster, for readers and writers of tiles. Every value equals that
/// of the whole transform to the bit. With SchemeSpec::exact the recursion reaches everywhere: then
/// whole lattices are needed.
namespace relief::multires::cubic {

/// The part of every band, in the order of the layout, that the values of `level` on `window`
/// depend on. Each level adds 6 even and 12 odd rows and columns on every side, cut at the band;
/// over all levels a box is at most 18 coefficients larger than the window. Bands of `level` and
/// finer ones are not needed and have an empty box. Requires: 0 <= level <= levels; `window` not
/// empty and inside scaling_box(layout, level). Complexity: O(levels).
[[nodiscard]] std::vector<LatticeBox> needed_boxes(const PyramidLayout& layout, int level,
                                                   const LatticeBox& window);

/// The values of `level` on `window`. bands[k] holds the coefficients of needed_boxes(..)[k] of one
/// component. Errors: InvalidArgument for a level or window that does not exist, or bands of other
/// sizes. Complexity: O(coefficients given).
template <class T>
[[nodiscard]] Result<Grid<T>> synthesise_window(const PyramidLayout& layout, int level,
                                                const LatticeBox& window,
                                                const std::vector<GridView<const T>>& bands);

/// What one level of analysis needs and gives for a window of the lattice of `level`.
struct AnalysisBoxes {
    LatticeBox finer;  ///< values of level - 1 that are read: up to 24 samples on every side
    /// Of the values of `level` (channel 0: the window) and its details (channels 1 .. 3).
    std::array<LatticeBox, 4> bands;
};

/// Requires: 1 <= level <= levels; `window` not empty and inside scaling_box(layout, level).
[[nodiscard]] AnalysisBoxes analysis_boxes(const PyramidLayout& layout, int level,
                                           const LatticeBox& window);

/// Analysis of the values of level - 1 on analysis_boxes(..).finer: grids of the boxes `bands` by
/// channel. Errors: InvalidArgument for a level or window that does not exist, or values of another
/// size. Complexity: O(values given).
template <class T>
[[nodiscard]] Result<std::array<Grid<T>, 4>> analyse_window(const PyramidLayout& layout, int level,
                                                            const LatticeBox& window,
                                                            GridView<const T> finer);

}  // namespace relief::multires::cubic
