#pragma once

#include "relief/spline/fvs_cell.h"
#include "spline/box_kernels.h"

/// Evaluation of C1 cubic cells. Private to the module.
namespace relief::spline {

/// All that a kernel needs to know of a surface with cells of size 1.
template <class T>
struct FvsKernel {
    std::array<const T*, kFvsPlanes> plane{};
    std::array<CellIndex<T>, kFvsPlanes> stride{};
    T first_row = 0;  ///< the domain; exact in T
    T last_row = 0;
    T first_col = 0;
    T last_col = 0;
    CellIndex<T> row0 = 0;  ///< first and last cells, which may be more than the domain needs
    CellIndex<T> col0 = 0;
    CellIndex<T> end_row = 0;
    CellIndex<T> end_col = 0;
};

/// Points by cell, counted from the first one, and place in it, 0 <= fi, fj <= 1.
template <class T>
struct FvsPoints {
    std::int64_t count = 0;
    const CellIndex<T>* row = nullptr;
    const CellIndex<T>* col = nullptr;
    const T* fi = nullptr;
    const T* fj = nullptr;
};

/// Cells and places of points, moved into the domain first. Exact: no rounding occurs.
template <class T>
void locate_fvs_points(const FvsKernel<T>& surface, std::int64_t count, const T* i, const T* j,
                       CellIndex<T>* row, CellIndex<T>* col, T* fi, T* fj);

/// Jets at many points, by vector kernel or scalar twin (relief/core/simd.h).
template <class T>
void fvs_jets_at(const FvsKernel<T>& surface, const FvsPoints<T>& points, const JetRows<T>& out);

/// The jet at place (fi, fj) of a cell: the scalar twin for one point. Rows and columns of any
/// size.
template <class T>
[[nodiscard]] SurfaceJet<T> fvs_jet_at(const FvsGridView<const T>& grid, std::int64_t row,
                                       std::int64_t col, T fi, T fj);

/// The largest absolute ordinate of the cells of a row; numbers[k] are their numbers k, cells of
/// a x b.
template <class T>
void fvs_ordinate_bounds_row(const std::array<const T*, kFvsCellNumbers>& numbers, T a, T b,
                             std::int64_t cells, T* bounds);

}  // namespace relief::spline
