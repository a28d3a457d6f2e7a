#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "relief/multires/mesh_frames.h"
#include "relief/multires/mesh_lift.h"
#include "relief/multires/mesh_smooth.h"
#include "relief/multires/mesh_step.h"

/// Meshes that are subdivisions of a coarse one: their connectivity, recognised in a fine mesh or
/// made from a coarse one, and their coefficients. Source: reverse-subdivision.md sections 7, 9.
namespace relief::multires {

/// What fixes the steps of a hierarchy.
struct MeshSpec {
    MeshScheme scheme = MeshScheme::Loop;
    bool first_even = false;           ///< sqrt(3): the step from the base is an even one
    std::optional<double> alpha = {};  ///< as StepOptions

    [[nodiscard]] mesh::Split split(int step) const {
        return split_of(scheme, step + (first_even ? 1 : 0));
    }
    /// Whether a mesh can be split so often. Errors: mesh::check_size.
    [[nodiscard]] Status check_steps(const mesh::Topology& base, int steps) const;

    friend bool operator==(const MeshSpec&, const MeshSpec&) = default;
};

/// A base mesh and `steps` subdivisions of it. Depth 0 is the base, depth k is reached by k steps;
/// vertices keep their numbers from one depth to the next.
class MeshHierarchy {
  public:
    /// The finest level has its faces alone, where no step follows that would ask for more: `twin`
    /// and `edge` are empty, unless the base is the finest level or has sharp edges. Errors: those
    /// of step_rules and mesh::refine. Complexity: O(finest mesh).
    [[nodiscard]] static Result<MeshHierarchy> create(mesh::Topology base, MeshTags tags,
                                                      const MeshSpec& spec, int steps);

    [[nodiscard]] const MeshSpec& spec() const { return spec_; }
    [[nodiscard]] int steps() const { return static_cast<int>(rules_.size()); }
    [[nodiscard]] const mesh::Topology& topology(int depth) const { return *levels_[at(depth)]; }
    [[nodiscard]] const MeshTags& tags(int depth) const { return tags_[at(depth)]; }
    [[nodiscard]] const StepRules& rules(int step) const { return *rules_[at(step)]; }
    template <class T = double>
    [[nodiscard]] MeshStep<T> step(int number) const {
        return {topology(number), rules(number)};
    }
    [[nodiscard]] std::size_t vertices(int depth) const { return topology(depth).vertex_count; }

  private:
    static std::size_t at(int k) { return static_cast<std::size_t>(k); }

    MeshSpec spec_;
    // On the heap, so that steps stay valid when the hierarchy moves.
    std::vector<std::unique_ptr<mesh::Topology>> levels_;
    std::vector<std::unique_ptr<StepRules>> rules_;
    std::vector<MeshTags> tags_;
};

/// Where a mesh comes from.
struct MeshOrigin {
    mesh::Topology base;
    MeshTags tags;  ///< of the base
    MeshSpec spec;
    int steps = 0;
    /// For each face of the finest level of the hierarchy the half-edge of the mesh that it begins
    /// with: this tells the numbers of its vertices and faces as well. Empty: both count alike.
    Buffer<mesh::Index> corners;
    /// Sharp edges of the mesh, inside it, of which no edge of the base is the origin.
    std::vector<mesh::Index> lost_creases;

    /// Of the mesh, for half-edge h of the finest level.
    [[nodiscard]] mesh::Index half_edge(mesh::Index h) const {
        if (corners.size() == 0) return h;
        const auto sides = static_cast<mesh::Index>(mesh::sides_after(spec.split(0)));
        const mesh::Index first = corners[h / sides];
        const mesh::Index turn = first % sides;
        return first - turn + (turn + h % sides) % sides;
    }
    /// The finest level and the mesh count alike.
    [[nodiscard]] bool in_order() const;
};

/// Goes down as many steps as the mesh has and `most` allows. Where components can be seen as split
/// in several ways, the way is taken from which subdivision comes nearest to the points; but a mesh
/// that has the numbers of subdivision is seen as these say. tags: of the mesh. Errors: BadInput
/// no_subdivision_connectivity; those of step_rules. Complexity: O(n).
[[nodiscard]] Result<MeshOrigin> origin_of(const mesh::Topology& mesh,
                                           std::span<const Vec3<double>> points,
                                           const MeshTags& tags, MeshScheme scheme, int most);

/// The same with another numbering of the base: vertices[v] is the number so far of vertex v,
/// corners[f] the half-edge so far that face f begins with. Complexity: O(n).
[[nodiscard]] Result<MeshOrigin> renumbered(const MeshOrigin& origin,
                                            std::span<const mesh::Index> vertices,
                                            std::span<const mesh::Index> corners);

/// How coefficients are made.
struct MeshTransform {
    LiftKind lift = LiftKind::Chebyshev;
    bool local_frames = false;  ///< details along the normal and tangents of the coarser surface
    /// Residuals of stiff vertices are inside the details, so that there are none beside them:
    /// multires/mesh_packed.h.
    bool packed = false;
    /// In (0, 1]; below 1, coarse meshes are smoothed after lifting: multires/mesh_smooth.h.
    double omega = 1;
    /// Of each step, Chebyshev; empty: default_lift.
    std::vector<LiftOptions> lifts = {};

    [[nodiscard]] LiftOptions lift_of(const MeshHierarchy& hierarchy, int step) const;
};

/// Residuals of the stiff vertices of each step; mostly none, and none if they are packed.
using StiffResiduals = std::vector<std::vector<Vec3<double>>>;

/// Frames in which the details of a step are expressed: those of the surface of its coarse
/// vertices.
class DetailFrames {
  public:
    DetailFrames(const MeshHierarchy& hierarchy, int step, const Vec3<double>* coarse);

    [[nodiscard]] const std::vector<MeshFrame>& fresh() const { return fresh_; }
    [[nodiscard]] const std::vector<MeshFrame>& stiff() const { return stiff_; }
    /// From the coordinates' frame, and back.
    void in(Vec3<double>* details, std::vector<Vec3<double>>& residuals) const;
    void out(Vec3<double>* details, std::vector<Vec3<double>>& residuals) const;

  private:
    std::vector<MeshFrame> fresh_;
    std::vector<MeshFrame> stiff_;
};

/// The transform of a hierarchy, both ways. In place: an array of the points of the finest mesh, in
/// the numbers of the hierarchy, becomes that of the coefficients: those of the base, followed by
/// the details of steps 0, 1, ..
class MeshMaps {
  public:
    /// The hierarchy must outlive this. Errors: those of MeshLift::create, MeshSmoothing::create
    /// and check_packed. Complexity: O(n).
    [[nodiscard]] static Result<MeshMaps> create(const MeshHierarchy& hierarchy,
                                                 const MeshTransform& transform);

    /// From the mesh of depth step + 1 to that of depth `step` and details. Complexity: O(n) a
    /// sweep.
    void analyse_step(int step, Vec3<double>* points, std::vector<Vec3<double>>& residuals) const;
    /// The reverse.
    void synthesise_step(int step, Vec3<double>* points,
                         const std::vector<Vec3<double>>& residuals) const;
    /// The same for details in the coordinates' frame, whatever the transform says.
    void synthesise_global(int step, Vec3<double>* points,
                           const std::vector<Vec3<double>>& residuals) const;

    void analyse(Vec3<double>* points, StiffResiduals& residuals) const;
    /// From depth `from` to depth `to`: coefficients of finer steps are left as they are.
    void synthesise(int from, int to, Vec3<double>* points, const StiffResiduals& residuals) const;

  private:
    const MeshHierarchy* hierarchy_ = nullptr;
    bool local_frames_ = false;
    bool packed_ = false;
    std::vector<std::unique_ptr<MeshStep<double>>> steps_;
    std::vector<MeshLift> lifts_;
    std::vector<MeshSmoothing> smoothings_;  ///< none: nothing is smoothed
};

}  // namespace relief::multires
