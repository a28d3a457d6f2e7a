#pragma once

#include <algorithm>
#include <cstring>
#include <utility>

#include "franke.h"
#include "relief/multires/fvs_grid_transform.h"
#include "relief/spline/fvs_surface.h"
#include "support.h"

namespace relief::multires::fvs {

template <class T>
FvsGrid<T> clone(const FvsGrid<T>& grid) {
    FvsGrid<T> copy(grid.nx(), grid.ny(), grid.a, grid.b);
    for (int p = 0; p < spline::kFvsPlanes; ++p) copy[p] = grid[p].clone();
    return copy;
}

template <class T>
FvsGrid<T> noisy_grid(std::int64_t nx, std::int64_t ny, std::uint64_t seed, double a = 1,
                      double b = 1) {
    FvsGrid<T> grid(nx, ny, a, b);
    for (int p = 0; p < spline::kFvsPlanes; ++p)
        grid[p] = test::noise_grid<T>(grid[p].rows(), grid[p].cols(), seed + std::uint64_t(p));
    return grid;
}

template <class T>
Details<T> noisy_details(std::int64_t nx, std::int64_t ny, std::uint64_t seed) {
    Details<T> details(nx, ny);
    for (int k = 0; k < kDetailKinds; ++k)
        details[k] =
            test::noise_grid<T>(details[k].rows(), details[k].cols(), seed + std::uint64_t(k));
    return details;
}

template <class T>
double largest_difference(const FvsGrid<T>& a, const FvsGrid<T>& b) {
    double largest = 0;
    for (int p = 0; p < spline::kFvsPlanes; ++p)
        largest = std::max(largest, test::largest_difference(a[p], b[p]));
    return largest;
}

template <class T>
double largest_difference(const Details<T>& a, const Details<T>& b) {
    double largest = 0;
    for (int k = 0; k < kDetailKinds; ++k)
        largest = std::max(largest, test::largest_difference(a[k], b[k]));
    return largest;
}

/// Nodal data of a function with known gradient on n x n cells of the unit square.
template <class Function>
FvsGrid<double> hermite_grid(std::int64_t n, Function f) {
    const double h = 1 / double(n);
    FvsGrid<double> grid(n, n, h, h);
    for (std::int64_t r = 0; r <= n; ++r)
        for (std::int64_t c = 0; c <= n; ++c) {
            const double x = double(c) * h, y = double(r) * h;
            const test::Gradient at = f(x, y);
            grid[spline::kFvsF](r, c) = at.value;
            grid[spline::kFvsFx](r, c) = at.x;
            grid[spline::kFvsFy](r, c) = at.y;
            if (c < n) grid[spline::kFvsGh](r, c) = f(x + h / 2, y).y;
            if (r < n) grid[spline::kFvsGv](r, c) = f(x, y + h / 2).x;
        }
    return grid;
}

}  // namespace relief::multires::fvs
