#include "codec/quantised_refit.h"

#include <cmath>
#include <limits>
#include <vector>

#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

constexpr int kRounds = 4;
/// Values within 0.65 steps of 0 count as 0.
constexpr double kRounding = 0.35;
/// How far coefficients move that are not 0, and that are.
constexpr double kShare = 0.15;
constexpr double kShareOfZeros = 0.08;

/// fn(band, component, row) for all rows of bands from `first_band` on.
template <class Function>
void for_all_rows(const Pyramid<double>& pyramid, std::size_t first_band, Function fn) {
    for (std::size_t k = first_band; k < pyramid.bands.size(); ++k)
        for (std::size_t p = 0; p < pyramid.bands[k].size(); ++p)
            parallel_for(0, pyramid.bands[k][p].rows(), 64,
                         [&](std::int64_t first, std::int64_t last) {
                             for (std::int64_t r = first; r < last; ++r) fn(k, p, r);
                         });
}

void quantise_into(const Pyramid<double>& pyramid, const PyramidCoding& coding,
                   std::size_t first_band, Pyramid<double>& quantised) {
    for_all_rows(pyramid, first_band, [&](std::size_t k, std::size_t p, std::int64_t r) {
        const double step = coding.step_of(pyramid.layout, k);
        const double mean = k == 0 ? coding.means[p] : 0;
        const double* from = pyramid.bands[k][p].row(r);
        double* to = quantised.bands[k][p].row(r);
        for (std::int64_t c = 0; c < quantised.bands[k][p].cols(); ++c) {
            const double size = std::floor(std::abs(from[c] - mean) / step + kRounding);
            to[c] = mean + std::copysign(size * step, from[c] - mean);
        }
    });
}

/// What the surface lacks, 0 in holes; and the sum of its squares.
double residual_of(const Target& target, multires::Planes<double>& surface) {
    double sum = 0;
    for (std::size_t p = 0; p < surface.size(); ++p)
        for (std::int64_t r = 0; r < surface[p].rows(); ++r)
            for (std::int64_t c = 0; c < surface[p].cols(); ++c) {
                const bool counts = target.mask.data == nullptr || target.mask(r, c) != 0;
                const double missing = counts ? target.planes[p](r, c) - surface[p](r, c) : 0;
                surface[p](r, c) = missing;
                sum += missing * missing;
            }
    return sum;
}

}  // namespace

void refit_quantised(Pyramid<double>& pyramid, const PyramidCoding& coding, const Target& target,
                     std::size_t first_band) {
    auto quantised = Pyramid<double>::allocate(pyramid.layout);
    for (std::size_t k = 0; k < first_band; ++k)
        for (std::size_t p = 0; p < pyramid.bands[k].size(); ++p)
            quantised.bands[k][p] = pyramid.bands[k][p].clone();
    double least = std::numeric_limits<double>::infinity();
    for (int round = 0; round < kRounds; ++round) {
        quantise_into(pyramid, coding, first_band, quantised);
        multires::Planes<double> residual = multires::synthesise(quantised);
        const double error = residual_of(target, residual);
        if (error > least) return;  // it would diverge
        least = error;
        std::vector<GridView<const double>> views;
        for (const Grid<double>& plane : residual) views.push_back(plane.view());
        const auto gradient = multires::adjoint<double>(pyramid.layout, views);
        for_all_rows(pyramid, first_band, [&](std::size_t k, std::size_t p, std::int64_t r) {
            const double norm = pyramid.layout.bands[k].norm_samples;
            const double* g = gradient.bands[k][p].row(r);
            const double* q = quantised.bands[k][p].row(r);
            double* x = pyramid.bands[k][p].row(r);
            for (std::int64_t c = 0; c < pyramid.bands[k][p].cols(); ++c) {
                const double share = round == 0 || q[c] != 0 ? kShare : kShareOfZeros;
                x[c] += share * (q[c] + g[c] / (norm * norm) - x[c]);
            }
        });
    }
}

}  // namespace relief::codec
