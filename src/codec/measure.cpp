#include "relief/codec/measure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

struct RowSums {
    std::int64_t samples = 0;
    std::int64_t mask_differs = 0;
    double square = 0;
    double max = -1;
    std::int64_t worst_col = 0;
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
};

RowSums measure_row(const Raster& reference, const Raster& other, std::int64_t r) {
    RowSums sums;
    for (std::int64_t c = 0; c < reference.cols; ++c) {
        const bool valid = reference.valid(r, c);
        if (valid != other.valid(r, c)) ++sums.mask_differs;
        if (!valid || !other.valid(r, c)) continue;
        ++sums.samples;
        for (std::size_t p = 0; p < reference.planes.size(); ++p) {
            const double value = reference.planes[p](r, c);
            const double error = std::abs(other.planes[p](r, c) - value);
            sums.low = std::min(sums.low, value);
            sums.high = std::max(sums.high, value);
            sums.square += error * error;
            if (error > sums.max) {
                sums.max = error;
                sums.worst_col = c;
            }
        }
    }
    return sums;
}

}  // namespace

Result<Measure> measure(const Raster& reference, const Raster& other) {
    const auto size = [](const Raster& raster) {
        return std::to_string(raster.cols) + " x " + std::to_string(raster.rows) + " with " +
               std::to_string(raster.planes.size()) + " bands";
    };
    if (reference.rows != other.rows || reference.cols != other.cols ||
        reference.planes.size() != other.planes.size())
        return Error{ErrorCode::BadInput,
                     "can not compare " + size(reference) + " to " + size(other), ""};
    std::vector<RowSums> rows(static_cast<std::size_t>(reference.rows));
    parallel_for(0, reference.rows, 64, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r)
            rows[static_cast<std::size_t>(r)] = measure_row(reference, other, r);
    });
    RowSums all;
    Measure result;
    for (std::int64_t r = 0; r < reference.rows; ++r) {
        const RowSums& row = rows[static_cast<std::size_t>(r)];
        all.samples += row.samples;
        all.mask_differs += row.mask_differs;
        all.square += row.square;
        all.low = std::min(all.low, row.low);
        all.high = std::max(all.high, row.high);
        if (row.max <= all.max) continue;
        all.max = row.max;
        result.worst_row = r;
        result.worst_col = row.worst_col;
    }
    if (all.samples == 0)
        return Error{ErrorCode::BadInput, "no sample is valid in both rasters", ""};
    result.samples = all.samples;
    result.mask_differs = all.mask_differs;
    result.max_error = all.max;
    result.mean_square = all.square / static_cast<double>(all.samples);
    result.rms_error = std::sqrt(result.mean_square);
    result.range = all.high - all.low;
    result.psnr_db = result.rms_error > 0 ? 20 * std::log10(result.range / result.rms_error)
                                          : std::numeric_limits<double>::infinity();
    return result;
}

}  // namespace relief::codec
