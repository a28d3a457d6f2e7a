#include "edit/mesh_patch.h"

#include <algorithm>

#include <cstdio>
#include <ctime>
static double now_ms(){timespec t;clock_gettime(CLOCK_THREAD_CPUTIME_ID,&t);return t.tv_sec*1e3+t.tv_nsec*1e-6;}
namespace relief::edit {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Split;

/// How many rings before the cut nothing may change.
constexpr int kWatchedRings = 2;

std::vector<Index> vertices_of(std::span<const VertexChange> changes) {
    std::vector<Index> vertices;
    for (const VertexChange& change : changes) vertices.push_back(change.vertex);
    return vertices;
}

}  // namespace

Result<MeshPatch> MeshPatch::create(const MeshLevels& levels, int depth, const MeshPoints& points,
                                    std::span<const VertexChange> changes, int rings) {
    const multires::MeshHierarchy& whole = levels.hierarchy();
    MeshRegion region = region_around(whole.topology(depth), whole.tags(depth),
                                      levels.around[static_cast<std::size_t>(depth)],
                                      vertices_of(changes), rings, whole.spec().split(depth));
    MeshPatch patch;
    patch.rings_ = rings;
    patch.tolerance_ = levels.tolerance;
    patch.has_cut_ = region.has_cut;
    patch.place_.assign(whole.vertices(depth), kNone);
    for (Index v = 0; v < region.vertices.size(); ++v) {
        patch.place_[region.vertices[v]] = v;
        patch.coarse_.push_back(points[region.vertices[v]]);
    }
    RELIEF_CHECK(patch.make_step(levels, depth, region));
    patch.ring_ = std::move(region.rings);
    patch.name_fine(levels, depth, region);
    patch.take_details(levels, depth);
    if (patch.has_cut_) patch.find_watched();
    patch.turned_ =
        turned(patch.details_, multires::DetailFrames(*patch.hierarchy_, 0, patch.coarse_.data()));
    return patch;
}

Status MeshPatch::make_step(const MeshLevels& levels, int depth, MeshRegion& region) {
    const multires::MeshHierarchy& whole = levels.hierarchy();
    multires::MeshSpec spec = whole.spec();
    spec.first_even = spec.split(depth) == Split::Sqrt3Even;
    RELIEF_TRY(auto hierarchy, multires::MeshHierarchy::create(std::move(region.mesh),
                                                               std::move(region.tags), spec, 1));
    hierarchy_ = std::make_unique<multires::MeshHierarchy>(std::move(hierarchy));
    multires::MeshTransform transform = levels.parts.transform;
    transform.lifts = {transform.lift_of(whole, depth)};
    RELIEF_TRY(maps_, multires::MeshMaps::create(*hierarchy_, transform));
    return {};
}

/// New vertices are called by their edges and faces. Faces that are trisected only because they
/// are on the cut have points that the mesh does not have.
void MeshPatch::name_fine(const MeshLevels& levels, int depth, const MeshRegion& region) {
    const mesh::Topology& part = hierarchy_->topology(0);
    const mesh::Topology& whole = levels.topology(depth);
    const multires::StepRules& here = hierarchy_->rules(0);
    const multires::StepRules& there = levels.hierarchy().rules(depth);
    fine_.assign(hierarchy_->vertices(1), kNone);
    std::copy(region.vertices.begin(), region.vertices.end(), fine_.begin());
    const bool on_edges = here.split == Split::Loop || here.split == Split::CatmullClark;
    for (Index h = 0; on_edges && h < part.half_edge_count(); ++h)
        fine_[part.vertex_count + part.edge[h]] =
            whole.vertex_count + whole.edge[region.half_edges[h]];
    for (Index f = 0; here.split != Split::Loop && f < part.face_count; ++f) {
        const Index first = region.half_edges[part.first_of(f)];
        const Index side = here.split == Split::Sqrt3Even ? mesh::boundary_side(part, f) : kNone;
        if (side != kNone && region.on_cut[part.edge[side]]) continue;
        const Index count = side == kNone ? 1 : 2;
        for (Index k = 0; k < count; ++k)
            fine_[here.face_points[f] + k] = there.face_points[whole.face_of(first)] + k;
    }
}

void MeshPatch::take_details(const MeshLevels& levels, int depth) {
    const multires::LocalDetails& all = levels.parts.details[static_cast<std::size_t>(depth)];
    const std::size_t coarse = coarse_.size();
    const auto first = static_cast<Index>(levels.hierarchy().vertices(depth));
    details_.fresh.resize(fine_.size() - coarse);
    for (std::size_t k = coarse; k < fine_.size(); ++k)
        if (fine_[k] != kNone) details_.fresh[k - coarse] = all.fresh[fine_[k] - first];
    const std::vector<Index>& stiff = levels.hierarchy().rules(depth).stiff.vertices;
    for (const Index v : hierarchy_->rules(0).stiff.vertices) {
        const auto place = std::lower_bound(stiff.begin(), stiff.end(), fine_[v]) - stiff.begin();
        details_.stiff.push_back(all.stiff[static_cast<std::size_t>(place)]);
    }
}

/// Those that have no vertex beside them that is further inside.
void MeshPatch::find_watched() {
    const mesh::Topology& fine = hierarchy_->topology(1);
    std::vector<bool> inside(fine_.size(), false);
    const auto is_inner = [&](Index v) {
        return v < ring_.size() && ring_[v] < rings_ - kWatchedRings;
    };
    for (Index f = 0; f < fine.face_count; ++f) {
        const auto corners = fine.corners(f);
        if (!std::any_of(corners.begin(), corners.end(), is_inner)) continue;
        for (const Index v : corners)
            if (v >= ring_.size() || is_inner(v)) inside[v] = true;
    }
    for (Index v = 0; v < inside.size(); ++v)
        if (!inside[v]) watched_.push_back(v);
}

bool MeshPatch::covers(std::span<const VertexChange> changes) const {
    return std::all_of(changes.begin(), changes.end(), [&](const VertexChange& change) {
        const Index v = place_[change.vertex];
        return v != kNone && (!has_cut_ || ring_[v] <= rings_ / 2);
    });
}

std::optional<std::vector<VertexChange>> MeshPatch::spread(
    std::span<const VertexChange> changes) const {
    double t0=now_ms(); MeshPoints moved = coarse_;
    MeshPoints delta(fine_.size());
    for (const VertexChange& change : changes) {
        moved[place_[change.vertex]] += change.delta;
        delta[place_[change.vertex]] = change.delta;
    }
    double t1=now_ms(); const multires::DetailFrames frames(*hierarchy_, 0, moved.data()); double t2=now_ms();
    for (std::size_t k = 0; k < details_.fresh.size(); ++k)
        delta[coarse_.size() + k] = details_.fresh[k].turned(frames.fresh()[k]) - turned_.fresh[k];
    MeshPoints stiff(details_.stiff.size());
    for (std::size_t k = 0; k < stiff.size(); ++k)
        stiff[k] = details_.stiff[k].turned(frames.stiff()[k]) - turned_.stiff[k];
    double t3=now_ms(); maps_.synthesise_global(0, delta.data(), stiff); double t4=now_ms();

    const double least = tolerance_ * tolerance_;
    const auto changed = [&](Index v) { return dot(delta[v], delta[v]) > least; };
    if (std::any_of(watched_.begin(), watched_.end(), changed)) return {};
    std::vector<VertexChange> result;
    for (Index v = 0; v < delta.size(); ++v)
        if (changed(v) && fine_[v] != kNone) result.push_back({fine_[v], delta[v]});
    fprintf(stderr,"    D %zu patch %zu rings %d -> %zu: copy %.2f frames %.2f turn %.2f synth %.2f collect %.2f\n",changes.size(),coarse_.size(),rings_,result.size(),t1-t0,t2-t1,t3-t2,t4-t3,now_ms()-t4); return result;
}

}  // namespace relief::edit
