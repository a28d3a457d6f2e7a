#pragma once

#include "relief/core/grid.h"
#include "relief/core/result.h"
#include "relief/spline/box_spline.h"

/// Linear maps between the coefficients of a box-spline surface on a rows x cols box and its values
/// at the lattice points. Beyond the box coefficients continue by reflection in the outermost ones,
/// first along i, then along j: c(-k) = 2 c(0) - c(min(k, n - 1)), likewise at the far end; a box
/// one wide continues as a constant.
///
/// All functions take float or double, any sizes >= 1, and work in parallel over tiles; results do
/// not depend on the number of threads. Outputs have the size of the inputs and must not overlap
/// them. Values that are not finite spread. Errors: InvalidArgument for an order outside 1 .. 4 or
/// sizes that differ, BadInput for an empty box. Order 1 interpolates: its samples are its
/// coefficients.
namespace relief::spline {

/// samples = B coefficients: the surface at the lattice points. Complexity: O(1, 7, 19, 37 taps a
/// sample).
template <class T>
[[nodiscard]] Status sample_lattice(int order, GridView<const T> coefficients, GridView<T> samples);

/// out = B^T residuals, the exact transpose of sample_lattice including the border: <B c, r> = <c,
/// B^T r>.
template <class T>
[[nodiscard]] Status sample_lattice_adjoint(int order, GridView<const T> residuals,
                                            GridView<T> out);

/// Solves B coefficients = samples. The residual |samples - B c| stays below 4 eps max |c|: for
/// orders 2 and 3 below 1e-14 (double) and 1e-6 (float) of the largest sample; order 4 reaches
/// 2e-14 and 3e-6 on white noise, whose coefficients are up to 50 times as large. Chebyshev cycles
/// in T, each from the residual of the one before. Complexity: 40, 88, 200 (double) or 24, 40, 96
/// (float) applications of B for orders 2, 3, 4; one temporary grid.
template <class T>
[[nodiscard]] Status interpolate_lattice(int order, GridView<const T> samples,
                                         GridView<T> coefficients);

/// coefficients = sum over m < order of (1 - B)^m samples: local, approximation order 2 order,
/// exact for planes up to the border and for polynomials of degree 2 order - 1 away from it. Order
/// 2: 3/2 f - 1/12 of the six neighbours. Complexity: order - 1 applications of B.
template <class T>
[[nodiscard]] Status quasi_interpolate(int order, GridView<const T> samples,
                                       GridView<T> coefficients);

/// out = G coefficients, with zero outside the box: c^T G c is the squared L2 norm over the plane
/// of the surface whose other coefficients are zero (unit cells). Complexity: O(7, 37, 91, 169 taps
/// a coefficient).
template <class T>
[[nodiscard]] Status gram_apply(int order, GridView<const T> coefficients, GridView<T> out);

}  // namespace relief::spline
