#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "codec/ps_details.h"
#include "relief/codec/ps_codec.h"
#include "relief/mesh/triangle_locator.h"

/// How far a spline is from what it stands for.
namespace relief::codec {

struct PsErrors {
    double max = 0;
    double square = 0;  ///< weighted sum, or integral
    double weight = 1;  ///< sum of the weights, or the area; for each component

    [[nodiscard]] double rms() const;
};

/// Errors at data points.
class PsDataErrors {
  public:
    /// space and data must outlive this. Requires: data of the right sizes, finite.
    PsDataErrors(const multires::ps::Space& space, const PsData& data);

    /// Errors: those of multires::ps::Surface.
    [[nodiscard]] Result<PsErrors> of(const LevelHeights& splines) const;

  private:
    const multires::ps::Space& space_;
    const PsData& data_;
    std::vector<mesh::TrianglePlace> places_;
};

/// The largest difference of heights, which bounds that of the surfaces, and the integral of the
/// squared difference. Requires: splines of the space.
[[nodiscard]] PsErrors surface_errors(const multires::ps::Space& space, const LevelHeights& a,
                                      const LevelHeights& b);

/// The largest difference of heights.
[[nodiscard]] double largest_difference(const LevelHeights& a, const LevelHeights& b);

}  // namespace relief::codec
