#include "relief/codec/quantise.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

constexpr double kLargestValue = 1 << 30;

double largest_magnitude(const multires::Planes<double>& band) {
    double largest = 0;
    for (const Grid<double>& plane : band)
        for (std::int64_t r = 0; r < plane.rows(); ++r)
            for (std::int64_t c = 0; c < plane.cols(); ++c)
                largest = std::max(largest, std::abs(plane(r, c)));
    return largest;
}

Grid<std::int32_t> quantise_plane(const Grid<double>& plane, double step, double rounding) {
    Grid<std::int32_t> values(plane.rows(), plane.cols());
    parallel_for(0, plane.rows(), 64, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r) {
            const double* c = plane.row(r);
            std::int32_t* q = values.row(r);
            for (std::int64_t k = 0; k < plane.cols(); ++k) {
                const auto size = static_cast<std::int32_t>(std::abs(c[k]) / step + rounding);
                q[k] = c[k] < 0 ? -size : size;
            }
        }
    });
    return values;
}

/// step_of(band index, largest magnitude) gives the wanted step.
template <class StepOf>
Quantised quantise_with(const Pyramid<double>& pyramid, double rounding, StepOf step_of) {
    Quantised result;
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
        const double largest = largest_magnitude(pyramid.bands[k]);
        const double wanted = std::max(step_of(k, largest), largest / kLargestValue);
        // A float that is not below the wanted step keeps the values in range.
        float step =
            static_cast<float>(std::min(wanted, double{std::numeric_limits<float>::max()}));
        if (step < wanted) step = std::nextafter(step, INFINITY);
        if (!(step > 0)) step = 1;
        std::vector<Grid<std::int32_t>> planes;
        for (const Grid<double>& plane : pyramid.bands[k])
            planes.push_back(quantise_plane(plane, step, k == 0 ? 0.5 : rounding));
        result.values.push_back(std::move(planes));
        result.steps.push_back(step);
    }
    result.kept = count_kept(result);
    return result;
}

}  // namespace

Quantised quantise(const Pyramid<double>& pyramid, double unit, double rounding) {
    return quantise_with(pyramid, rounding, [&](std::size_t k, double) {
        return unit / band_norm(pyramid.layout.bands[k], Metric::Samples);
    });
}

Quantised quantise_finely(const Pyramid<double>& pyramid) {
    return quantise_with(pyramid, 0.5,
                         [](std::size_t, double largest) { return std::ldexp(largest, -24); });
}

void dequantise(const Quantised& quantised, Pyramid<double>& pyramid, int finest_level) {
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
        const bool zero = k > 0 && pyramid.layout.bands[k].level <= finest_level;
        const double step = quantised.steps[k];
        for (std::size_t p = 0; p < pyramid.bands[k].size(); ++p) {
            Grid<double>& plane = pyramid.bands[k][p];
            parallel_for(0, plane.rows(), 64, [&](std::int64_t first, std::int64_t last) {
                for (std::int64_t r = first; r < last; ++r)
                    for (std::int64_t c = 0; c < plane.cols(); ++c)
                        plane(r, c) = zero ? 0.0 : quantised.values[k][p](r, c) * step;
            });
        }
    }
}

std::int64_t count_kept(const Quantised& quantised) {
    std::int64_t kept = quantised.values[0][0].count();
    for (std::size_t k = 1; k < quantised.values.size(); ++k) {
        const auto& planes = quantised.values[k];
        for (std::int64_t r = 0; r < planes[0].rows(); ++r)
            for (std::int64_t c = 0; c < planes[0].cols(); ++c)
                kept += std::any_of(planes.begin(), planes.end(),
                                    [&](const auto& plane) { return plane(r, c) != 0; });
    }
    return kept;
}

}  // namespace relief::codec
