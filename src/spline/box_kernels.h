#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "relief/spline/box_surface.h"

namespace relief::spline {

/// Counts grid elements from the corner of the padded coefficients; as wide as T, so that one
/// vector indexes another.
template <class T>
using CellIndex = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;

/// The Bezier ordinates of the lower triangle as sparse sums over the window of reaching control
/// points.
template <class T>
struct OrdinateSums {
    struct Term {
        T weight;
        int control;  ///< index into the window
    };
    std::vector<Term> terms;
    std::vector<int> ends;  ///< ordinate k sums the terms ends[k - 1] .. ends[k] - 1
    double scale = 1;       ///< by which the sums are too large
};

/// Where the window's control points stand relative to the cell's own, in grid elements, per
/// triangle.
template <class T>
struct WindowOffsets {
    static constexpr int kMaxControls = 48;
    int count = 0;
    CellIndex<T> lower[kMaxControls];
    CellIndex<T> upper[kMaxControls];
};

/// All that a kernel needs to know of a surface.
template <class T>
struct KernelSurface {
    int order = 1;
    const OrdinateSums<T>* sums = nullptr;
    WindowOffsets<T> offsets;
    const T* corner = nullptr;  ///< first element of the padded grid
    CellIndex<T> origin = 0;    ///< element of control point (0, 0)
    CellIndex<T> stride = 0;
    T last_row = 0;  ///< the domain; exact in T
    T last_col = 0;

    [[nodiscard]] const CellIndex<T>* window(T fi, T fj) const {
        return fj > fi ? offsets.upper : offsets.lower;
    }
};

/// Points by cell (element of the cell's own control point) and place in the cell, 0 <= fi, fj
/// <= 1.
template <class T>
struct CellPoints {
    std::int64_t count = 0;
    const CellIndex<T>* cell = nullptr;
    const T* fi = nullptr;
    const T* fj = nullptr;
};

/// Results, one array a quantity; those beyond `derivatives` are not touched.
template <class T>
struct JetRows {
    int derivatives = 0;
    T* value = nullptr;
    T* di = nullptr;
    T* dj = nullptr;
    T* dii = nullptr;
    T* dij = nullptr;
    T* djj = nullptr;
};

template <class T>
void store_jet(const SurfaceJet<T>& jet, const JetRows<T>& out, std::int64_t k = 0) {
    out.value[k] = jet.value;
    if (out.derivatives >= 1) {
        out.di[k] = jet.di;
        out.dj[k] = jet.dj;
    }
    if (out.derivatives >= 2) {
        out.dii[k] = jet.dii;
        out.dij[k] = jet.dij;
        out.djj[k] = jet.djj;
    }
}

/// Cells and places of points, moved into the domain first. Exact: no rounding occurs.
template <class T>
void locate_points(const KernelSurface<T>& surface, std::int64_t count, const T* i, const T* j,
                   CellIndex<T>* cell, T* fi, T* fj);

/// Jets at many points, by vector kernel or scalar twin (relief/core/simd.h).
template <class T>
void jets_at(const KernelSurface<T>& surface, const CellPoints<T>& points, const JetRows<T>& out);

/// The jet at place (fi, fj) of the cell whose own control point is `cell`: the scalar twin for one
/// point.
template <class T>
[[nodiscard]] SurfaceJet<T> jet_at(const KernelSurface<T>& surface, const T* cell, T fi, T fj);

/// The weights that the value at (fi, fj) gives to the control points of the window, in order.
template <class T>
void window_weights(const KernelSurface<T>& surface, double fi, double fj, double* weights);

}  // namespace relief::spline
