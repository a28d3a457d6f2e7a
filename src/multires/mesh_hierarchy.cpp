#include "relief/multires/mesh_hierarchy.h"

#include <algorithm>
#include <utility>

#include "relief/multires/mesh_frames.h"

namespace relief::multires {

namespace {

using mesh::Index;
using Points = std::vector<Vec3<double>>;

/// Details of a step between the coordinates' frame and those of the surface of its coarse
/// vertices.
class Frames {
  public:
    Frames(const MeshHierarchy& hierarchy, int step, const Vec3<double>* coarse) {
        const MeshStep<double> maps = hierarchy.step(step);
        Points surface(hierarchy.vertices(step + 1));
        maps.apply(coarse, surface.data(), surface.data() + maps.coarse_count());
        const mesh::Topology& fine = hierarchy.topology(step + 1);
        fresh_ = frames(fine, surface.data(), static_cast<Index>(maps.coarse_count()));
        stiff_ = frames(fine, surface.data(), maps.rules().stiff.vertices);
    }

    void in(Vec3<double>* details, Points& residuals) const {
        for (std::size_t k = 0; k < fresh_.size(); ++k) details[k] = fresh_[k].in(details[k]);
        for (std::size_t k = 0; k < stiff_.size(); ++k) residuals[k] = stiff_[k].in(residuals[k]);
    }
    void out(Vec3<double>* details, Points& residuals) const {
        for (std::size_t k = 0; k < fresh_.size(); ++k) details[k] = fresh_[k].out(details[k]);
        for (std::size_t k = 0; k < stiff_.size(); ++k) residuals[k] = stiff_[k].out(residuals[k]);
    }

  private:
    std::vector<MeshFrame> fresh_;
    std::vector<MeshFrame> stiff_;
};

Status synthesise_step(const MeshHierarchy& hierarchy, const MeshTransform& transform, int step,
                       Vec3<double>* points, Points residuals) {
    const MeshStep<double> maps = hierarchy.step(step);
    const std::size_t coarse = maps.coarse_count();
    if (transform.local_frames) Frames(hierarchy, step, points).out(points + coarse, residuals);
    RELIEF_TRY(const MeshLift lift, MeshLift::create(maps, transform.lift_of(hierarchy, step)));
    Points scratch(hierarchy.vertices(step + 1));
    lift.apply(points + coarse, residuals.data(), scratch.data());
    for (std::size_t v = 0; v < coarse; ++v) points[v] -= scratch[v];
    maps.synthesise(points, residuals.data(), scratch.data());
    return {};
}

}  // namespace

Status MeshSpec::check_steps(const mesh::Topology& base, int steps) const {
    mesh::MeshCounts counts = mesh::counts_of(base);
    for (int step = 0; step < steps; ++step) {
        counts = mesh::refined(counts, split(step));
        RELIEF_CHECK(mesh::check_size(counts));
    }
    return {};
}

Result<MeshHierarchy> MeshHierarchy::create(mesh::Topology base, MeshTags tags,
                                            const MeshSpec& spec, int steps) {
    RELIEF_CHECK(spec.check_steps(base, steps));
    MeshHierarchy hierarchy;
    hierarchy.spec_ = spec;
    hierarchy.levels_.push_back(std::make_unique<mesh::Topology>(std::move(base)));
    hierarchy.tags_.push_back(std::move(tags));
    for (int step = 0; step < steps; ++step) {
        const mesh::Topology& coarse = hierarchy.topology(step);
        const mesh::Split split = spec.split(step);
        RELIEF_TRY(StepRules rules,
                   step_rules(coarse, hierarchy.tags(step), split, {.alpha = spec.alpha}));
        RELIEF_TRY(mesh::Topology fine, mesh::refine(coarse, split));
        MeshTags finer = refined(hierarchy.tags(step), coarse, fine, split);
        hierarchy.rules_.push_back(std::make_unique<StepRules>(std::move(rules)));
        hierarchy.levels_.push_back(std::make_unique<mesh::Topology>(std::move(fine)));
        hierarchy.tags_.push_back(std::move(finer));
    }
    return hierarchy;
}

LiftOptions MeshTransform::lift_of(const MeshHierarchy& hierarchy, int step) const {
    if (static_cast<std::size_t>(step) < lifts.size()) return lifts[static_cast<std::size_t>(step)];
    if (lift != LiftKind::Chebyshev) return {.kind = lift};
    return default_lift(hierarchy.spec().scheme, hierarchy.steps() - 1 - step);
}

Status analyse_step(const MeshHierarchy& hierarchy, const MeshTransform& transform, int step,
                    Vec3<double>* points, Points& residuals) {
    const MeshStep<double> maps = hierarchy.step(step);
    const std::size_t coarse = maps.coarse_count();
    Points scratch(hierarchy.vertices(step + 1));
    residuals.resize(maps.rules().stiff.size());
    maps.analyse(points, residuals.data(), scratch.data());
    RELIEF_TRY(const MeshLift lift, MeshLift::create(maps, transform.lift_of(hierarchy, step)));
    lift.apply(points + coarse, residuals.data(), scratch.data());
    for (std::size_t v = 0; v < coarse; ++v) points[v] += scratch[v];
    if (transform.local_frames) Frames(hierarchy, step, points).in(points + coarse, residuals);
    return {};
}

Status analyse(const MeshHierarchy& hierarchy, const MeshTransform& transform, Vec3<double>* points,
               StiffResiduals& residuals) {
    residuals.resize(static_cast<std::size_t>(hierarchy.steps()));
    for (int step = hierarchy.steps() - 1; step >= 0; --step)
        RELIEF_CHECK(analyse_step(hierarchy, transform, step, points,
                                  residuals[static_cast<std::size_t>(step)]));
    return {};
}

Status synthesise(const MeshHierarchy& hierarchy, const MeshTransform& transform, int from, int to,
                  Vec3<double>* points, const StiffResiduals& residuals) {
    for (int step = from; step < to; ++step)
        RELIEF_CHECK(synthesise_step(hierarchy, transform, step, points,
                                     residuals[static_cast<std::size_t>(step)]));
    return {};
}

}  // namespace relief::multires
