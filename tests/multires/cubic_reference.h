#pragma once

#include <cstdint>
#include <vector>

#include "relief/multires/pyramid.h"

/// Scheme `cubic` to the letter of its formulas: in place on the whole lattice, sample by sample.
namespace relief::multires::cubic::reference {

/// The specification's taps, to ten digits.
inline constexpr double kTaps[] = {0.6006476703,  -0.1274401096, 0.0341474745,
                                   -0.0091497882, 0.0024516784,  -0.0006569252};

inline std::int64_t mirrored(std::int64_t y, std::int64_t n) {
    while (y < 0 || y >= n) y = y < 0 ? -y : 2 * (n - 1) - y;
    return y;
}

/// d(2i+1) -= sum t_k (s(2i-2k) + s(2i+2+2k)), then s(2i) += 1/2 sum t_k (d(2i-1-2k) + d(2i+1+2k)).
inline void analyse_line(std::vector<double>& v) {
    const auto n = static_cast<std::int64_t>(v.size());
    if (n == 1) return;
    const auto sum = [&](std::int64_t y) {
        double total = 0;
        for (std::int64_t k = 0; k < 6; ++k)
            total += kTaps[k] * (v[std::size_t(mirrored(y - 1 - 2 * k, n))] +
                                 v[std::size_t(mirrored(y + 1 + 2 * k, n))]);
        return total;
    };
    for (std::int64_t y = 1; y < n; y += 2) v[std::size_t(y)] -= sum(y);
    for (std::int64_t y = 0; y < n; y += 2) v[std::size_t(y)] += 0.5 * sum(y);
}

/// Bands of one component, in the order of the layout.
inline std::vector<Grid<double>> analyse(const Grid<double>& finest, const PyramidLayout& layout) {
    std::vector<Grid<double>> bands(layout.bands.size());
    Grid<double> fine = finest.clone();
    for (int level = 1; level <= layout.levels(); ++level) {
        for (std::int64_t r = 0; r < fine.rows(); ++r) {
            std::vector<double> line(fine.row(r), fine.row(r) + fine.cols());
            analyse_line(line);
            for (std::int64_t c = 0; c < fine.cols(); ++c) fine(r, c) = line[std::size_t(c)];
        }
        for (std::int64_t c = 0; c < fine.cols(); ++c) {
            std::vector<double> line;
            for (std::int64_t r = 0; r < fine.rows(); ++r) line.push_back(fine(r, c));
            analyse_line(line);
            for (std::int64_t r = 0; r < fine.rows(); ++r) fine(r, c) = line[std::size_t(r)];
        }
        Grid<double> coarse((fine.rows() + 1) / 2, (fine.cols() + 1) / 2);
        const auto first = std::size_t(3 * (layout.levels() - level));
        for (std::size_t k = 1; k < 4; ++k) {
            const LatticeBox& box = layout.bands[first + k].box;
            bands[first + k] = Grid<double>(box.rows, box.cols);
        }
        for (std::int64_t r = 0; r < fine.rows(); ++r)
            for (std::int64_t c = 0; c < fine.cols(); ++c) {
                const auto channel = std::size_t(2 * (r % 2) + c % 2);
                (channel == 0 ? coarse : bands[first + channel])(r / 2, c / 2) = fine(r, c);
            }
        fine = std::move(coarse);
    }
    bands[0] = std::move(fine);
    return bands;
}

}  // namespace relief::multires::cubic::reference
