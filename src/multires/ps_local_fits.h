#pragma once

#include <cstddef>

/// Least-squares polynomials through a vertex, for several vertices at once: powell-sabin.md
/// section 12 (b), pass 1.
namespace relief::multires::ps {

inline constexpr std::size_t kFitLanes = 8;
inline constexpr std::size_t kStencilSize = 24;

/// The stencils of kFitLanes vertices: [point][vertex]. Offsets from the vertex, divided by their
/// root mean square, and differences of values. Points that a vertex does not have are zero.
struct alignas(64) FitStencils {
    double dx[kStencilSize][kFitLanes];
    double dy[kStencilSize][kFitLanes];
    double dz[kStencilSize][kFitLanes];
    double present[kStencilSize][kFitLanes];  ///< 1 or 0
    double count[kFitLanes];                  ///< of the points that are there
    std::size_t rows = 0;                     ///< the most of them
};

enum Degree : std::size_t { kLinear, kQuadratic, kCubic, kDegrees };

/// What the fits of one vertex say. Gradients are per unit of the divided offsets.
struct alignas(64) LocalFits {
    double gradient[kDegrees][2][kFitLanes];
    double error[kDegrees][kFitLanes];  ///< weighted mean square of the values when left out;
                                        ///< infinite: there is no such fit
    double zero_error[kFitLanes];       ///< the same of the prediction "as at the vertex"
    double plain[kFitLanes];            ///< how far off a free plane predicts the vertex (c1)
    double curved[kFitLanes];           ///< the same of a free quadratic (c2)
};

/// Vectors across vertices; every lane does the same operations in the same order, so that results
/// do not depend on the instruction set.
void fit_stencils(const FitStencils& stencils, LocalFits& fits);

}  // namespace relief::multires::ps
