#include "codec/surface_error.h"

#include <algorithm>
#include <vector>

#include "relief/core/parallel.h"

namespace relief::codec {

using multires::Planes;

SurfaceError surface_error(const Raster& raster, const Planes<double>& surface) {
    std::vector<SurfaceError> rows(static_cast<std::size_t>(raster.rows));
    parallel_for(0, raster.rows, 32, [&](std::int64_t first, std::int64_t last) {
        std::vector<double> stored(static_cast<std::size_t>(raster.cols));
        for (std::int64_t r = first; r < last; ++r) {
            SurfaceError row;
            const std::uint8_t* valid = raster.mask.empty() ? nullptr : raster.mask.row(r);
            for (std::size_t p = 0; p < surface.size(); ++p) {
                stored_row(surface[p].row(r), raster.cols, raster.type, raster.nodata,
                           stored.data());
                const double* wanted = raster.planes[p].row(r);
                for (std::int64_t c = 0; c < raster.cols; ++c) {
                    if (valid && !valid[c]) continue;
                    const double error = std::abs(stored[static_cast<std::size_t>(c)] - wanted[c]);
                    row.max = std::max(row.max, error);
                    row.square += error * error;
                }
            }
            rows[static_cast<std::size_t>(r)] = row;
        }
    });
    SurfaceError all;
    for (const SurfaceError& row : rows) {
        all.max = std::max(all.max, row.max);
        all.square += row.square;
    }
    return all;
}

double largest_error_of_level(const Raster& raster, const Planes<double>& planes, int level) {
    const std::int64_t step = std::int64_t{1} << level;
    double largest = 0;
    for (std::size_t p = 0; p < planes.size(); ++p)
        for (std::int64_t r = 0; r < planes[p].rows(); ++r)
            for (std::int64_t c = 0; c < planes[p].cols(); ++c) {
                if (!raster.valid(r * step, c * step)) continue;
                const double stored = stored_value(planes[p](r, c), raster.type, raster.nodata);
                largest =
                    std::max(largest, std::abs(stored - raster.planes[p](r * step, c * step)));
            }
    return largest;
}

EncodeReport size_report(const Raster& about, std::uint64_t bytes) {
    EncodeReport report;
    report.samples = about.rows * about.cols;
    report.bytes = bytes;
    report.bits_per_sample = 8.0 * static_cast<double>(bytes) / static_cast<double>(report.samples);
    return report;
}

void set_errors(EncodeReport& report, const SurfaceError& error, std::int64_t samples,
                double energy) {
    report.max_error = error.max;
    report.rms_error = error.rms(samples);
    report.energy_percent = energy > 0 ? 100 * error.square / energy : 0;
}

}  // namespace relief::codec
