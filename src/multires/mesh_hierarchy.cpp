#include "relief/multires/mesh_hierarchy.h"

#include <algorithm>
#include <utility>

#include "relief/multires/mesh_packed.h"

namespace relief::multires {

namespace {

using mesh::Index;
using Points = std::vector<Vec3<double>>;

/// The finer mesh without what its own split would need.
Result<mesh::Topology> refined_faces(const mesh::Topology& coarse, mesh::Split split) {
    RELIEF_CHECK(mesh::check_split(coarse, split));
    const mesh::MeshCounts counts = mesh::refined(mesh::counts_of(coarse), split);
    mesh::Topology fine;
    fine.vertex_count = static_cast<Index>(counts.vertices);
    fine.edge_count = static_cast<Index>(counts.edges);
    fine.face_count = static_cast<Index>(counts.faces);
    fine.sides = mesh::sides_after(split);
    fine.origin = Buffer<Index>(counts.half_edges);
    mesh::split_faces(coarse, split, {fine.origin.data(), fine.origin.size()});
    return fine;
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
        const bool faces_alone = step + 1 == steps && hierarchy.tags(step).sharp.empty();
        RELIEF_TRY(mesh::Topology fine,
                   faces_alone ? refined_faces(coarse, split) : mesh::refine(coarse, split));
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

DetailFrames::DetailFrames(const MeshHierarchy& hierarchy, int step, const Vec3<double>* coarse) {
    const MeshStep<double> maps = hierarchy.step(step);
    Points surface(hierarchy.vertices(step + 1));
    maps.apply(coarse, surface.data(), surface.data() + maps.coarse_count());
    const mesh::Topology& fine = hierarchy.topology(step + 1);
    fresh_ = frames(fine, surface.data(), static_cast<Index>(maps.coarse_count()));
    if (maps.rules().stiff.size() > 0)
        stiff_ = frames(fine, surface.data(), maps.rules().stiff.vertices);
}

void DetailFrames::in(Vec3<double>* details, Points& residuals) const {
    for (std::size_t k = 0; k < fresh_.size(); ++k) details[k] = fresh_[k].in(details[k]);
    for (std::size_t k = 0; k < residuals.size(); ++k) residuals[k] = stiff_[k].in(residuals[k]);
}

void DetailFrames::out(Vec3<double>* details, Points& residuals) const {
    for (std::size_t k = 0; k < fresh_.size(); ++k) details[k] = fresh_[k].out(details[k]);
    for (std::size_t k = 0; k < residuals.size(); ++k) residuals[k] = stiff_[k].out(residuals[k]);
}

Result<MeshMaps> MeshMaps::create(const MeshHierarchy& hierarchy, const MeshTransform& transform) {
    MeshMaps maps;
    maps.hierarchy_ = &hierarchy;
    maps.local_frames_ = transform.local_frames;
    maps.packed_ = transform.packed;
    for (int step = 0; step < hierarchy.steps(); ++step) {
        maps.steps_.push_back(std::make_unique<MeshStep<double>>(hierarchy.step(step)));
        RELIEF_TRY(MeshLift lift,
                   MeshLift::create(*maps.steps_.back(), transform.lift_of(hierarchy, step)));
        maps.lifts_.push_back(std::move(lift));
        if (transform.packed) RELIEF_CHECK(check_packed(hierarchy.rules(step)));
        if (transform.omega == 1) continue;
        RELIEF_TRY(const MeshSmoothing smoothing,
                   MeshSmoothing::create(*maps.steps_.back(), transform.omega));
        maps.smoothings_.push_back(smoothing);
    }
    return maps;
}

void MeshMaps::analyse_step(int step, Vec3<double>* points, Points& residuals) const {
    const MeshStep<double>& maps = *steps_[static_cast<std::size_t>(step)];
    const std::size_t coarse = maps.coarse_count();
    Buffer<Vec3<double>> scratch(coarse);
    residuals.resize(maps.rules().stiff.size());
    maps.analyse(points, residuals.data(), scratch.data());
    lifts_[static_cast<std::size_t>(step)].apply(points + coarse, residuals.data(), scratch.data());
    for (std::size_t v = 0; v < coarse; ++v) points[v] += scratch[v];
    if (!smoothings_.empty()) smoothings_[static_cast<std::size_t>(step)].smooth(points);
    if (packed_) {
        pack_residuals(maps, residuals.data(), points + coarse);
        residuals.clear();
    }
    if (local_frames_) DetailFrames(*hierarchy_, step, points).in(points + coarse, residuals);
}

void MeshMaps::synthesise_step(int step, Vec3<double>* points, const Points& residuals) const {
    if (!local_frames_) return synthesise_global(step, points, residuals);
    Points global = residuals;
    DetailFrames(*hierarchy_, step, points).out(points + hierarchy_->vertices(step), global);
    synthesise_global(step, points, global);
}

void MeshMaps::synthesise_global(int step, Vec3<double>* points, const Points& residuals) const {
    const MeshStep<double>& maps = *steps_[static_cast<std::size_t>(step)];
    const std::size_t coarse = maps.coarse_count();
    Buffer<Vec3<double>> scratch(coarse);
    Points unpacked(packed_ ? maps.rules().stiff.size() : 0);
    if (packed_) unpack_residuals(maps, points + coarse, unpacked.data());
    const Points& stiff = packed_ ? unpacked : residuals;
    if (!smoothings_.empty()) smoothings_[static_cast<std::size_t>(step)].restore(points);
    lifts_[static_cast<std::size_t>(step)].apply(points + coarse, stiff.data(), scratch.data());
    for (std::size_t v = 0; v < coarse; ++v) points[v] -= scratch[v];
    maps.synthesise(points, stiff.data(), scratch.data());
}

void MeshMaps::analyse(Vec3<double>* points, StiffResiduals& residuals) const {
    residuals.resize(steps_.size());
    for (int step = hierarchy_->steps() - 1; step >= 0; --step)
        analyse_step(step, points, residuals[static_cast<std::size_t>(step)]);
}

void MeshMaps::synthesise(int from, int to, Vec3<double>* points,
                          const StiffResiduals& residuals) const {
    for (int step = from; step < to; ++step)
        synthesise_step(step, points, residuals[static_cast<std::size_t>(step)]);
}

}  // namespace relief::multires
