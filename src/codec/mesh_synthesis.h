#pragma once

#include <memory>
#include <vector>

#include "codec/mesh_base.h"
#include "codec/mesh_details.h"
#include "codec/mesh_header.h"
#include "relief/multires/mesh_moves.h"

/// From quantised coefficients to points: what encoder and decoder of meshes share.
namespace relief::codec {

using MeshPoints = std::vector<Vec3<double>>;

/// The places of a base's grid points.
[[nodiscard]] Vec3<double> base_point(const MeshQuantisation& q, int steps, const GridPoint& p);
[[nodiscard]] GridPoint base_grid_point(const MeshQuantisation& q, int steps,
                                        const Vec3<double>& p);

/// Added before the fraction is left out: with less than half more details become zero.
inline constexpr double kThrifty = 0.42;
inline constexpr double kNearest = 0.5;

/// Details in steps, and back to where their mean is.
[[nodiscard]] QuantisedDetail quantised(const Vec3<double>& local, double step, double tangential,
                                        double rounding = kThrifty);
[[nodiscard]] Vec3<double> reconstructed(const QuantisedDetail& q, double step, double tangential);

/// Whether a detail has places on the grid that integers can count.
inline constexpr double kLargestQuotient = 0x1p50;

/// Details of a step where the frames of its surface are.
[[nodiscard]] multires::LocalDetails local_details(const MeshQuantisation& q, int steps, int step,
                                                   const QuantisedStep& details,
                                                   const multires::DetailFrames& frames);

/// A hierarchy with its maps.
class MeshSynthesis {
  public:
    /// Errors: those of MeshHierarchy and MeshMaps. steps: how many of the file's.
    [[nodiscard]] static Result<MeshSynthesis> create(mesh::Topology base, multires::MeshTags tags,
                                                      const MeshHeader& header, int steps);

    [[nodiscard]] const multires::MeshHierarchy& hierarchy() const { return *hierarchy_; }
    [[nodiscard]] const multires::MeshTransform& transform() const { return transform_; }
    [[nodiscard]] const multires::MeshMaps& maps() const { return *maps_; }

    /// points: those of depth `step`, of which the frames are; they become those of depth step + 1.
    /// Complexity: O(n) a sweep.
    void refine(const MeshQuantisation& q, int steps, int step, const QuantisedStep& details,
                const multires::DetailFrames& frames, MeshPoints& points) const;
    /// The same for a mesh that was moved.
    void refine_moved(int step, const multires::LocalDetails& details, MeshPoints& moved) const;

    /// The hierarchy is gone then.
    [[nodiscard]] std::unique_ptr<multires::MeshHierarchy> take_hierarchy() && {
        return std::move(hierarchy_);
    }

  private:
    // On the heap: maps refer to the hierarchy.
    std::unique_ptr<multires::MeshHierarchy> hierarchy_;
    multires::MeshTransform transform_;
    std::unique_ptr<multires::MeshMaps> maps_;
};

}  // namespace relief::codec
