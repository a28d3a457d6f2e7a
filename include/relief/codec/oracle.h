#pragma once

#include <cstdint>
#include <vector>

#include "relief/multires/scheme.h"

/// Which coefficients stay: magnitude weighted by the norm of the basis function, optionally
/// followed by least squares over the kept ones and by reselection. Knows pyramids, not schemes.
/// Specification: barycentric-mra section 10.
namespace relief::codec {

using multires::Pyramid;
using multires::PyramidLayout;

/// Which norm weights a coefficient.
enum class Metric : std::uint8_t {
    Samples,  ///< error at the raster samples: what `compare` measures
    Surface,  ///< L2 error of the surface, as in the source paper
};
[[nodiscard]] double band_norm(const multires::BandLayout& band, Metric metric);

/// What the kept coefficients must reproduce: the samples (all finite), and where they count.
struct Target {
    std::vector<GridView<const double>> planes;
    GridView<const std::uint8_t> mask;  ///< 1 counts, 0 does not; no data: all count
};

/// One mask for all components of a band: 1 kept. masks[k] belongs to band k.
struct Selection {
    std::vector<Grid<std::uint8_t>> masks;
    std::int64_t kept = 0;
};

/// The `keep` coefficients of largest weighted magnitude (root of the sum of squares over
/// components); the scaling band counts and always stays. Ties are broken by position. Complexity:
/// O(coefficients).
template <class T>
[[nodiscard]] Selection select_largest(const Pyramid<T>& pyramid, std::int64_t keep,
                                       Metric metric = Metric::Samples);

/// All coefficients whose weighted magnitude is at least `threshold`, and the scaling band.
template <class T>
[[nodiscard]] Selection select_above(const Pyramid<T>& pyramid, double threshold,
                                     Metric metric = Metric::Samples);

/// Sets what is not kept to zero.
template <class T>
void apply(const Selection& selection, Pyramid<T>& pyramid);

/// Least squares over the kept coefficients by conjugate gradients from their present values:
/// reduces the squared error at the samples of `target`. Requires: the rest of the pyramid is zero.
/// Complexity: O(iterations * samples).
void refit(Pyramid<double>& pyramid, const Selection& selection, const Target& target,
           int iterations = 20);

/// How much work goes into a choice of coefficients.
enum class Effort : std::uint8_t {
    Select,    ///< weighted magnitude only
    Refit,     ///< and least squares
    Reselect,  ///< and six rounds of reselection first; worthwhile for frames
};

/// Keeps `keep` coefficients of the analysis `pyramid` of `target` and improves them. Returns what
/// is kept.
Selection choose(Pyramid<double>& pyramid, std::int64_t keep, const Target& target, Effort effort);

}  // namespace relief::codec
