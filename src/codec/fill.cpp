#include "relief/codec/fill.h"

#include <algorithm>

namespace relief::codec {

namespace {

struct Weighted {
    Grid<double> value;
    Grid<std::uint8_t> known;
};

/// Means of the known values of 2 x 2 blocks.
Weighted halved(const Weighted& fine, bool& complete) {
    const std::int64_t rows = (fine.value.rows() + 1) / 2;
    const std::int64_t cols = (fine.value.cols() + 1) / 2;
    Weighted coarse{Grid<double>(rows, cols, 0.0), Grid<std::uint8_t>(rows, cols, std::uint8_t{0})};
    complete = true;
    for (std::int64_t r = 0; r < rows; ++r)
        for (std::int64_t c = 0; c < cols; ++c) {
            double sum = 0;
            int count = 0;
            for (std::int64_t i = 2 * r; i < std::min(2 * r + 2, fine.value.rows()); ++i)
                for (std::int64_t j = 2 * c; j < std::min(2 * c + 2, fine.value.cols()); ++j)
                    if (fine.known(i, j)) sum += fine.value(i, j), ++count;
            if (count > 0) coarse.value(r, c) = sum / count;
            coarse.known(r, c) = count > 0;
            complete = complete && count > 0;
        }
    return coarse;
}

/// Bilinear interpolation of cell means at fine cell (i, j).
double interpolated(const Grid<double>& coarse, std::int64_t i, std::int64_t j) {
    const auto clamp_row = [&](std::int64_t r) {
        return std::clamp<std::int64_t>(r, 0, coarse.rows() - 1);
    };
    const auto clamp_col = [&](std::int64_t c) {
        return std::clamp<std::int64_t>(c, 0, coarse.cols() - 1);
    };
    const std::int64_t r = i / 2;
    const std::int64_t c = j / 2;
    const std::int64_t other_r = clamp_row(i % 2 == 0 ? r - 1 : r + 1);
    const std::int64_t other_c = clamp_col(j % 2 == 0 ? c - 1 : c + 1);
    return 0.0625 * (9 * coarse(r, c) + 3 * coarse(other_r, c) + 3 * coarse(r, other_c) +
                     coarse(other_r, other_c));
}

void fill_levels(Weighted& fine) {
    bool complete = false;
    Weighted coarse = halved(fine, complete);
    if (!complete) fill_levels(coarse);
    for (std::int64_t r = 0; r < fine.value.rows(); ++r)
        for (std::int64_t c = 0; c < fine.value.cols(); ++c)
            if (!fine.known(r, c)) fine.value(r, c) = interpolated(coarse.value, r, c);
}

}  // namespace

Grid<double> filled(GridView<const double> plane, const Grid<std::uint8_t>& mask) {
    Weighted all{Grid<double>(plane.rows, plane.cols), {}};
    for (std::int64_t r = 0; r < plane.rows; ++r)
        std::copy_n(plane.row(r), plane.cols, all.value.row(r));
    if (mask.empty()) return std::move(all.value);
    all.known = mask.clone();
    fill_levels(all);
    return std::move(all.value);
}

}  // namespace relief::codec
