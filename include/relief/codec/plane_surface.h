#pragma once

#include <memory>
#include <span>

#include "relief/codec/ps_codec.h"
#include "relief/codec/quad_codec.h"
#include "relief/codec/raster_codec.h"
#include "relief/core/vec2.h"
#include "relief/spline/fvs_element.h"

namespace relief::codec {

/// The surface that a file over the plane describes, to be asked at places in the units of its
/// data: those of the raster's transform (column and row without one), of the mesh, of the points.
/// Several threads may ask.
class PlaneSurface {
  public:
    PlaneSurface() = default;
    PlaneSurface(const PlaneSurface&) = delete;
    PlaneSurface& operator=(const PlaneSurface&) = delete;
    virtual ~PlaneSurface() = default;

    [[nodiscard]] virtual int components() const = 0;

    /// Jets of component c at place k go to out[k * components() + c]: values, with derivatives 1
    /// gradients too, with 2 Hessians too; what was not asked for is unspecified. All numbers are
    /// NaN outside the surface, in holes, and at places that are not finite. Errors:
    /// InvalidArgument if derivatives is not 0, 1 or 2 or `out` has not the size of the places;
    /// BadFile for rasters whose tiles there are damaged. Complexity: O(places); rasters above 2^22
    /// samples in tiles are decoded where places are, others once.
    [[nodiscard]] virtual Status evaluate(std::span<const Vec2> places, int derivatives,
                                          std::span<spline::PlaneJet> out) const = 0;

  protected:
    [[nodiscard]] Status check(std::span<const Vec2> places, int derivatives,
                               std::span<const spline::PlaneJet> out) const;
};

/// Of the finest level. The raster file must outlive the surface. Errors: those of the files;
/// BadInput for a raster whose transform gives different samples the same place.
[[nodiscard]] Result<std::unique_ptr<const PlaneSurface>> plane_surface(const RasterFile& file);
[[nodiscard]] Result<std::unique_ptr<const PlaneSurface>> plane_surface(const QuadFile& file);
[[nodiscard]] Result<std::unique_ptr<const PlaneSurface>> plane_surface(const PsFile& file);

}  // namespace relief::codec
