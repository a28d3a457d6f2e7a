#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "relief/multires/scheme.h"

/// Multiresolution editing: a scaling coefficient of any level is moved, the details stay.
namespace relief::multires {

/// Adds delta to scaling coefficient (row, col) of `level`, in lattice indices of that level: the
/// surface changes by delta * M(2^-level . - (row, col)), with M the box spline or, for scheme
/// `cubic`, its cardinal spline: the surface moves by delta at that point, and at no other lattice
/// point of the level. Components beyond the surface's are
/// ignored.
struct Move {
    int level = 0;
    std::int64_t row = 0;
    std::int64_t col = 0;
    std::array<double, 4> delta{};
};

/// Whether a move names an existing coefficient. Errors: InvalidArgument naming the range.
[[nodiscard]] Status check_move(const PyramidLayout& layout, const Move& move);

/// Applies moves to the pyramid itself: bands of levels up to a move's keep every bit, coarser ones
/// change so that the scaling coefficients of that level are the moved ones. Complexity: O(samples
/// / 4^level) a level with moves. Errors: those of check_move; the pyramid is then unchanged.
template <class T>
Status apply_moves(Pyramid<T>& pyramid, const std::vector<Move>& moves);

/// What moves do to the scaling coefficients of `level`, by themselves: zero where nothing changes.
/// Moves at levels finer than `level` count as details and are left out. Requires: checked moves.
template <class T>
[[nodiscard]] LevelCoefficients<T> displacement(const PyramidLayout& layout,
                                                const std::vector<Move>& moves, int level);

/// Which samples of `level` the moves can change (the box of their supports, clipped to the
/// raster).
[[nodiscard]] LatticeBox touched_box(const PyramidLayout& layout, const std::vector<Move>& moves,
                                     int level = 0);

}  // namespace relief::multires
