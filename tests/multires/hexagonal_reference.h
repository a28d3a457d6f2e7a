#pragma once

#include <array>

#include "relief/multires/barycentric.h"

/// The definition, kept as the tests' reference: convolution with the projected hexagonal kernels,
/// tap by tap.
namespace relief::test {

using multires::FilterBank;
using multires::HexKernel;

/// Value of the extension of a grid at any lattice point (specification section 5), one axis after
/// the other.
inline double extended(const Grid<double>& grid, const LatticeBox& box, std::int64_t i,
                       std::int64_t j) {
    const auto along = [](std::int64_t k, std::int64_t n, auto&& value) {
        if (k < 0) return 2 * value(std::int64_t{0}) - value(std::min(-k, n - 1));
        if (k > n - 1) return 2 * value(n - 1) - value(std::max<std::int64_t>(2 * (n - 1) - k, 0));
        return value(k);
    };
    return along(j - box.col0, box.cols, [&](std::int64_t c) {
        return along(i - box.row0, box.rows, [&](std::int64_t r) { return grid(r, c); });
    });
}

/// sum K(k) fine(2x + k) for x in `box`.
template <class Fine>
Grid<double> direct_analysis(const HexKernel& kernel, const LatticeBox& box, Fine&& fine) {
    Grid<double> out(box.rows, box.cols, 0.0);
    for (std::int64_t r = 0; r < box.rows; ++r)
        for (std::int64_t c = 0; c < box.cols; ++c)
            for (std::int64_t i = kernel.box.row0; i < kernel.box.row0 + kernel.box.rows; ++i)
                for (std::int64_t j = kernel.box.col0; j < kernel.box.col0 + kernel.box.cols; ++j)
                    out(r, c) += kernel(static_cast<int>(i), static_cast<int>(j)) *
                                 fine(2 * (box.row0 + r) + i, 2 * (box.col0 + c) + j);
    return out;
}

/// fine += sum_x K(y - 2x) channel(x).
inline void direct_synthesis(const HexKernel& kernel, const LatticeBox& box,
                             const Grid<double>& channel, const LatticeBox& fine_box,
                             Grid<double>& fine) {
    for (std::int64_t r = 0; r < box.rows; ++r)
        for (std::int64_t c = 0; c < box.cols; ++c)
            for (std::int64_t i = kernel.box.row0; i < kernel.box.row0 + kernel.box.rows; ++i)
                for (std::int64_t j = kernel.box.col0; j < kernel.box.col0 + kernel.box.cols; ++j) {
                    const std::int64_t row = 2 * (box.row0 + r) + i;
                    const std::int64_t col = 2 * (box.col0 + c) + j;
                    if (fine_box.contains(row, col))
                        fine(row - fine_box.row0, col - fine_box.col0) +=
                            kernel(static_cast<int>(i), static_cast<int>(j)) * channel(r, c);
                }
}

}  // namespace relief::test
