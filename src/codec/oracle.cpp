#include "relief/codec/oracle.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

template <class T>
double magnitude(const multires::Planes<T>& band, std::int64_t r, std::int64_t c) {
    if (band.size() == 1) return std::abs(static_cast<double>(band[0](r, c)));
    double square = 0;
    for (const Grid<T>& plane : band) {
        const double x = plane(r, c);
        square += x * x;
    }
    return std::sqrt(square);
}

/// What multiplies a magnitude to give its weight: the norm of the band, less where an atom reaches
/// over the border.
class Weights {
  public:
    Weights(const PyramidLayout& layout, Metric metric)
        : layout_(layout), metric_(metric), coverage_(multires::coverage(layout)) {}

    [[nodiscard]] double operator()(std::size_t band, std::int64_t r, std::int64_t c) const {
        const double norm = band_norm(layout_.bands[band], metric_);
        return coverage_.empty() ? norm
                                 : norm * std::sqrt(static_cast<double>(coverage_[band](r, c)));
    }

  private:
    const PyramidLayout& layout_;
    Metric metric_;
    std::vector<Grid<float>> coverage_;
};

/// Sum over rows of row_sum(r), added in row order whatever the threads.
template <class RowSum>
double ordered_sum(std::int64_t rows, RowSum row_sum) {
    std::vector<double> sums(static_cast<std::size_t>(rows));
    parallel_for(0, rows, 64, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t r = first; r < last; ++r) sums[static_cast<std::size_t>(r)] = row_sum(r);
    });
    double total = 0;
    for (const double sum : sums) total += sum;
    return total;
}

/// Calls fn(row of a, row of b, row of mask, cols, weight) for all rows of all planes.
class Kept {
  public:
    Kept(const PyramidLayout& layout, const Selection& selection)
        : layout_(layout), selection_(selection) {}

    /// sum over kept coefficients of a * b
    [[nodiscard]] double dot(const Pyramid<double>& a, const Pyramid<double>& b) const {
        double total = 0;
        for (std::size_t k = 0; k < a.bands.size(); ++k)
            for (std::size_t p = 0; p < a.bands[k].size(); ++p)
                total += ordered_sum(a.bands[k][p].rows(), [&](std::int64_t r) {
                    const double* x = a.bands[k][p].row(r);
                    const double* y = b.bands[k][p].row(r);
                    const std::uint8_t* kept = selection_.masks[k].row(r);
                    double sum = 0;
                    for (std::int64_t c = 0; c < a.bands[k][p].cols(); ++c)
                        sum += kept[c] ? x[c] * y[c] : 0.0;
                    return sum;
                });
        return total;
    }

    /// fn(element of a, element of b, norm of the band) for kept elements, writing into a; others
    /// become zero.
    template <class T, class Function>
    void update(Pyramid<T>& a, const Pyramid<T>& b, Function fn) const {
        for (std::size_t k = 0; k < a.bands.size(); ++k) {
            const double norm = band_norm(layout_.bands[k], Metric::Samples);
            for (std::size_t p = 0; p < a.bands[k].size(); ++p)
                parallel_for(0, a.bands[k][p].rows(), 64,
                             [&](std::int64_t first, std::int64_t last) {
                                 for (std::int64_t r = first; r < last; ++r) {
                                     T* x = a.bands[k][p].row(r);
                                     const T* y = b.bands[k][p].row(r);
                                     const std::uint8_t* kept = selection_.masks[k].row(r);
                                     for (std::int64_t c = 0; c < a.bands[k][p].cols(); ++c)
                                         x[c] = kept[c] ? fn(x[c], y[c], norm) : T(0);
                                 }
                             });
        }
    }

  private:
    const PyramidLayout& layout_;
    const Selection& selection_;
};

/// mask * (target - surface), or mask * surface when subtract is false.
multires::Planes<double> masked_residual(const Target& target, multires::Planes<double> surface,
                                         bool subtract) {
    for (std::size_t p = 0; p < surface.size(); ++p)
        parallel_for(0, surface[p].rows(), 64, [&](std::int64_t first, std::int64_t last) {
            for (std::int64_t r = first; r < last; ++r) {
                double* s = surface[p].row(r);
                const double* f = target.planes[p].row(r);
                if (subtract)
                    for (std::int64_t c = 0; c < surface[p].cols(); ++c) s[c] = f[c] - s[c];
                if (!target.mask.data) continue;
                const std::uint8_t* mask = target.mask.row(r);
                for (std::int64_t c = 0; c < surface[p].cols(); ++c)
                    if (!mask[c]) s[c] = 0;
            }
        });
    return surface;
}

std::vector<GridView<const double>> views(const multires::Planes<double>& planes) {
    std::vector<GridView<const double>> result;
    for (const Grid<double>& plane : planes) result.push_back(plane.view());
    return result;
}

Pyramid<double> zeros(const PyramidLayout& layout) {
    auto pyramid = Pyramid<double>::allocate(layout);
    for (auto& band : pyramid.bands)
        for (Grid<double>& plane : band)
            for (std::int64_t r = 0; r < plane.rows(); ++r)
                std::fill_n(plane.row(r), plane.cols(), 0.0);
    return pyramid;
}

template <class T>
Selection select_where(const Pyramid<T>& pyramid, double threshold, std::int64_t ties,
                       Metric metric) {
    Selection selection;
    const Weights weight(pyramid.layout, metric);
    for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
        const LatticeBox& box = pyramid.layout.bands[k].box;
        Grid<std::uint8_t> mask(box.rows, box.cols);
        for (std::int64_t r = 0; r < box.rows; ++r)
            for (std::int64_t c = 0; c < box.cols; ++c) {
                const double weighted =
                    k == 0 ? INFINITY : magnitude(pyramid.bands[k], r, c) * weight(k, r, c);
                const bool kept = weighted > threshold || (weighted == threshold && ties-- > 0);
                mask(r, c) = kept;
                selection.kept += kept;
            }
        selection.masks.push_back(std::move(mask));
    }
    return selection;
}

}  // namespace

double band_norm(const multires::BandLayout& band, Metric metric) {
    return metric == Metric::Samples ? band.norm_samples : band.norm_surface;
}

template <class T>
Selection select_largest(const Pyramid<T>& pyramid, std::int64_t keep, Metric metric) {
    const std::int64_t always = pyramid.layout.bands[0].box.count();
    const std::int64_t wanted = std::max<std::int64_t>(0, keep - always);
    const Weights weight(pyramid.layout, metric);
    std::vector<double> weighted;
    weighted.reserve(static_cast<std::size_t>(pyramid.layout.coefficients() - always));
    for (std::size_t k = 1; k < pyramid.bands.size(); ++k) {
        const LatticeBox& box = pyramid.layout.bands[k].box;
        for (std::int64_t r = 0; r < box.rows; ++r)
            for (std::int64_t c = 0; c < box.cols; ++c)
                weighted.push_back(magnitude(pyramid.bands[k], r, c) * weight(k, r, c));
    }
    if (wanted >= static_cast<std::int64_t>(weighted.size()))
        return select_where(pyramid, -1, 0, metric);
    if (wanted == 0) return select_where(pyramid, std::numeric_limits<double>::max(), 0, metric);
    const auto last = weighted.begin() + (wanted - 1);
    std::nth_element(weighted.begin(), last, weighted.end(), std::greater<>());
    const double threshold = *last;
    const auto above =
        std::count_if(weighted.begin(), weighted.end(), [&](double w) { return w > threshold; });
    return select_where(pyramid, threshold, wanted - above, metric);
}

template <class T>
Selection select_above(const Pyramid<T>& pyramid, double threshold, Metric metric) {
    return select_where(pyramid, threshold, std::numeric_limits<std::int64_t>::max(), metric);
}

template <class T>
void apply(const Selection& selection, Pyramid<T>& pyramid) {
    Kept(pyramid.layout, selection).update(pyramid, pyramid, [](T x, T, double) { return x; });
}

template Selection select_largest(const Pyramid<float>&, std::int64_t, Metric);
template Selection select_largest(const Pyramid<double>&, std::int64_t, Metric);
template Selection select_above(const Pyramid<float>&, double, Metric);
template Selection select_above(const Pyramid<double>&, double, Metric);
template void apply(const Selection&, Pyramid<float>&);
template void apply(const Selection&, Pyramid<double>&);

void refit(Pyramid<double>& pyramid, const Selection& selection, const Target& target,
           int iterations) {
    // Conjugate gradients for (S W^-1)^T (S W^-1) y = (S W^-1)^T f over the kept y = W c, written
    // in terms of c: residuals and directions below are those of y divided by W.
    const PyramidLayout& layout = pyramid.layout;
    const Kept kept(layout, selection);
    const auto gradient_of = [&](multires::Planes<double> residual) {
        auto gradient = multires::adjoint<double>(layout, views(residual));
        kept.update(gradient, gradient, [](double g, double, double norm) { return g / norm; });
        return gradient;
    };
    Pyramid<double> residual =
        gradient_of(masked_residual(target, multires::synthesise(pyramid), true));
    Pyramid<double> direction = zeros(layout);
    double energy = kept.dot(residual, residual);
    const double negligible = energy * 1e-24;
    double momentum = 0;
    for (int k = 0; k < iterations && energy > negligible && energy > 0; ++k) {
        kept.update(direction, residual,
                    [&](double d, double r, double norm) { return r / norm + momentum * d; });
        auto image = masked_residual(target, multires::synthesise(direction), false);
        double image_energy = 0;
        for (const Grid<double>& plane : image)
            image_energy += ordered_sum(plane.rows(), [&](std::int64_t r) {
                double sum = 0;
                for (std::int64_t c = 0; c < plane.cols(); ++c) sum += plane(r, c) * plane(r, c);
                return sum;
            });
        if (!(image_energy > 0)) return;
        const double step = energy / image_energy;
        kept.update(pyramid, direction, [&](double c, double d, double) { return c + step * d; });
        const Pyramid<double> curvature = gradient_of(std::move(image));
        kept.update(residual, curvature, [&](double r, double a, double) { return r - step * a; });
        const double next = kept.dot(residual, residual);
        momentum = next / energy;
        energy = next;
    }
}

Selection choose(Pyramid<double>& pyramid, std::int64_t keep, const Target& target, Effort effort) {
    Selection selection = select_largest(pyramid, keep);
    const bool all = selection.kept == pyramid.layout.coefficients();
    apply(selection, pyramid);
    if (all || effort == Effort::Select) return selection;
    constexpr int rounds = 6;
    for (int k = 0; effort == Effort::Reselect && k < rounds; ++k) {
        const auto missing = masked_residual(target, multires::synthesise(pyramid), true);
        auto correction = multires::analyse<double>(views(missing), pyramid.layout.spec);
        if (!correction.ok()) break;
        for (std::size_t b = 0; b < pyramid.bands.size(); ++b)
            for (std::size_t p = 0; p < pyramid.bands[b].size(); ++p)
                for (std::int64_t r = 0; r < pyramid.bands[b][p].rows(); ++r)
                    for (std::int64_t c = 0; c < pyramid.bands[b][p].cols(); ++c)
                        pyramid.bands[b][p](r, c) += correction->bands[b][p](r, c);
        selection = select_largest(pyramid, keep);
        apply(selection, pyramid);
        refit(pyramid, selection, target, 8);
    }
    refit(pyramid, selection, target);
    return selection;
}

}  // namespace relief::codec
