#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "relief/multires/fvs_grid_transform.h"

/// The rules of the hierarchical transform of C1 cubic splines as data. Private to the module.
namespace relief::multires::fvs {

/// What the details of a kind belong to: their index is that of an edge or cell of the coarse grid.
enum class Owner { HorizontalEdge, VerticalEdge, Cell };

/// Where a kind stands in the fine data: planes[plane](2 r + row, 2 c + col).
struct DetailPlace {
    std::string_view name;
    Owner owner;
    int plane;
    int row;
    int col;
};
inline constexpr std::array<DetailPlace, kDetailKinds> kDetailPlaces = {
    {{"ehv", Owner::HorizontalEdge, spline::kFvsF, 0, 1},
     {"eht", Owner::HorizontalEdge, spline::kFvsFx, 0, 1},
     {"gh0a", Owner::HorizontalEdge, spline::kFvsGh, 0, 0},
     {"gh0b", Owner::HorizontalEdge, spline::kFvsGh, 0, 1},
     {"evv", Owner::VerticalEdge, spline::kFvsF, 1, 0},
     {"evt", Owner::VerticalEdge, spline::kFvsFy, 1, 0},
     {"gv0a", Owner::VerticalEdge, spline::kFvsGv, 0, 0},
     {"gv0b", Owner::VerticalEdge, spline::kFvsGv, 1, 0},
     {"cv", Owner::Cell, spline::kFvsF, 1, 1},
     {"cx", Owner::Cell, spline::kFvsFx, 1, 1},
     {"cy", Owner::Cell, spline::kFvsFy, 1, 1},
     {"gh1a", Owner::Cell, spline::kFvsGh, 1, 0},
     {"gh1b", Owner::Cell, spline::kFvsGh, 1, 1},
     {"gv1a", Owner::Cell, spline::kFvsGv, 0, 1},
     {"gv1b", Owner::Cell, spline::kFvsGv, 1, 1}}};

/// Where the coarse data stand in the fine ones, by coarse plane: nothing is computed.
struct CoarsePlace {
    int plane;
    int row;
    int col;
};
inline constexpr std::array<CoarsePlace, spline::kFvsPlanes> kCoarsePlaces = {
    {{spline::kFvsF, 0, 0},
     {spline::kFvsFx, 0, 0},
     {spline::kFvsFy, 0, 0},
     {spline::kFvsFy, 0, 1},
     {spline::kFvsFx, 1, 0}}};

/// A weight of coarse number planes[plane](r + row, c + col) for the detail (r, c) of some kind.
struct Tap {
    int plane;
    int row;
    int col;
    double weight;
};
using Taps = std::vector<Tap>;

/// What the coarse spline has in the places of the details, for coarse cells of a x b: closed forms
/// of section 5.
[[nodiscard]] std::array<Taps, kDetailKinds> prediction_taps(double a, double b);

/// Which coarse cells exist around an edge or cell, along one axis of n cells: the class of index
/// k. Cells: before, after. Edges: the cells on both sides, and those behind them.
[[nodiscard]] constexpr int cell_class(std::int64_t k, std::int64_t n) {
    return (k > 0 ? 1 : 0) + (k < n - 1 ? 2 : 0);
}
[[nodiscard]] constexpr int edge_class(std::int64_t k, std::int64_t n) {
    return (k > 0 ? 1 : 0) + (k < n ? 2 : 0) + (k > 1 ? 4 : 0) + (k < n - 1 ? 8 : 0);
}
inline constexpr int kClasses = 16;

/// The update U of section 9 for cells of size 1: column `kind` by the classes of its row and
/// column. Empty where the owner has no cell.
struct UpdateTaps {
    std::array<std::array<std::array<Taps, kClasses>, kClasses>, kDetailKinds> taps;

    [[nodiscard]] const Taps& at(int kind, int row_class, int col_class) const {
        return taps[std::size_t(kind)][std::size_t(row_class)][std::size_t(col_class)];
    }
};
[[nodiscard]] const UpdateTaps& update_taps();

}  // namespace relief::multires::fvs
