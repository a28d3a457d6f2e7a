#include "multires/mesh_descent.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "relief/mesh/walk.h"

namespace relief::multires {

using mesh::Index;
using mesh::Recognition;
using mesh::Split;
using mesh::Topology;
using mesh::Unsplit;

Buffer<Index> own_starts(const Topology& coarse, Split split) {
    Buffer<Index> starts(coarse.half_edge_count());
    const bool sqrt3 = split == Split::Sqrt3Odd || split == Split::Sqrt3Even;
    const Buffer<Index> faces = sqrt3 ? mesh::sqrt3_faces(coarse, split) : Buffer<Index>();
    for (Index h = 0; h < starts.size(); ++h)
        starts[h] = sqrt3                  ? 3 * faces[h]
                    : split == Split::Loop ? 12 * (h / 3) + 3 * (h % 3)
                                           : 4 * h;
    return starts;
}

MeshTags coarser_tags(const MeshTags& tags, const Topology& fine, const FoundLevel& found,
                      std::vector<Index>* lost) {
    const Topology& coarse = found.unsplit.mesh;
    MeshTags result;
    if (!tags.corner.empty()) {
        result.corner.resize(coarse.vertex_count);
        for (Index v = 0; v < coarse.vertex_count; ++v)
            result.corner[v] = tags.corner[found.unsplit.old_vertices[v]];
    }
    if (tags.sharp.empty()) return result;
    std::vector<std::uint8_t> kept(fine.edge_count, 0);
    result.sharp.assign(coarse.edge_count, 0);
    const bool halved = found.split == Split::Loop || found.split == Split::CatmullClark;
    mesh::each_edge(coarse, [&](Index h, Index, Index) {
        if (!halved || coarse.on_boundary(h)) return;
        const Index first = fine.edge[found.unsplit.fine[h]];
        const Index second = fine.edge[found.unsplit.fine[coarse.twin[h]]];
        if (!tags.sharp[first] || !tags.sharp[second]) return;
        result.sharp[coarse.edge[h]] = kept[first] = kept[second] = 1;
    });
    for (Index h = 0; lost && h < fine.half_edge_count(); ++h)
        if (fine.is_first(h) && !fine.on_boundary(h) && tags.sharp[fine.edge[h]] &&
            !kept[fine.edge[h]])
            lost->push_back(fine.edge[h]);
    return result;
}

namespace {

using Points = MeshDescent::Points;

/// A mesh in the numbers of the subdivision that it is.
struct Ordered {
    Points points;
    std::vector<Index> half_edge;  ///< [vertex]: one of the mesh's that begins there
};

Result<Ordered> ordered(const Topology& fine, std::span<const Vec3<double>> points,
                        const FoundLevel& found) {
    const Topology& coarse = found.unsplit.mesh;
    const mesh::MeshCounts counts = mesh::refined(mesh::counts_of(coarse), found.split);
    RELIEF_CHECK(mesh::check_split(coarse, found.split));
    Buffer<Index> corners(counts.half_edges);
    mesh::split_faces(coarse, found.split, {corners.data(), corners.size()});
    const auto half_edges = mesh::fine_half_edges(coarse, found.split, fine, found.unsplit.fine);
    Ordered result{Points(points.size()), std::vector<Index>(points.size())};
    for (Index h = 0; h < corners.size(); ++h) {
        result.points[corners[h]] = points[fine.origin[half_edges[h]]];
        result.half_edge[corners[h]] = half_edges[h];
    }
    return result;
}

/// The coarser mesh whose subdivision is near the points of the finer one.
Result<Points> lifted(const MeshStep<double>& step, Points c, MeshScheme scheme) {
    Points scratch(step.coarse_count());
    Points stiff(step.rules().stiff.size());
    step.analyse(c.data(), stiff.data(), scratch.data());
    RELIEF_TRY(const MeshLift lift, MeshLift::create(step, default_lift(scheme, 0)));
    lift.apply(c.data() + step.coarse_count(), stiff.data(), scratch.data());
    c.resize(step.coarse_count());
    for (std::size_t v = 0; v < c.size(); ++v) c[v] += scratch[v];
    return c;
}

using Choices = std::vector<std::vector<std::size_t>>;

std::size_t most_ways(const Choices& choices) {
    std::size_t most = 0;
    for (const auto& ways : choices) most = std::max(most, ways.size());
    return most;
}

bool any_empty(const Choices& choices) {
    return std::any_of(choices.begin(), choices.end(),
                       [](const auto& ways) { return ways.empty(); });
}

/// Way number `way` of each component, or its last.
std::vector<std::size_t> choice_of(const Choices& choices, std::size_t way) {
    std::vector<std::size_t> choice;
    for (const auto& ways : choices) choice.push_back(ways[std::min(way, ways.size() - 1)]);
    return choice;
}

}  // namespace

void MeshDescent::read_in_order(int most) {
    while (static_cast<int>(levels_.size()) < most) {
        const Split split = split_at(levels_.size());
        auto coarse = mesh::unsplit_in_order(finest_left(), split);
        if (!coarse) break;
        auto level = std::make_unique<FoundLevel>();
        level->split = split;
        level->in_order = true;
        level->unsplit.mesh = *std::move(coarse);
        levels_.push_back(std::move(level));
    }
    while (!levels_.empty() && !mesh::is_built(finest_left())) levels_.pop_back();
    if (!tags_.sharp.empty() || !tags_.corner.empty()) link_levels_in_order();
    for (std::size_t k = 0; k < levels_.size(); ++k)
        levels_[k]->tags =
            coarser_tags(k == 0 ? tags_ : levels_[k - 1]->tags, finer(k), *levels_[k], nullptr);
}

void MeshDescent::search(int most) {
    while (static_cast<int>(levels_.size()) < most) {
        if (!recognition_)
            recognition_ =
                std::make_unique<const Recognition>(finest_left(), split_at(levels_.size()));
        if (!recognition_->ok()) {
            reason_ = recognition_->error();
            return;
        }
        link_levels_in_order();
        Result<std::unique_ptr<FoundLevel>> level = choose();
        if (!level.ok()) {
            reason_ = level.error();
            return;
        }
        levels_.push_back(*std::move(level));
        recognition_ = ahead_ ? std::move(ahead_->next) : nullptr;
        ahead_.reset();
    }
}

/// Tells where in the finer mesh those levels are.
void MeshDescent::link_levels_in_order() {
    for (const auto& level : levels_) {
        Unsplit& unsplit = level->unsplit;
        if (!level->in_order || unsplit.fine.size() > 0) continue;
        unsplit.fine = own_starts(unsplit.mesh, level->split);
        unsplit.old_vertices.resize(unsplit.mesh.vertex_count);
        std::iota(unsplit.old_vertices.begin(), unsplit.old_vertices.end(), Index{0});
    }
}

/// Of the coarsest mesh so far. They are needed where there is a choice only.
Result<std::span<const Vec3<double>>> MeshDescent::points_left() {
    while (coarser_points_.size() < levels_.size()) {
        const std::size_t k = coarser_points_.size();
        const FoundLevel& level = *levels_[k];
        RELIEF_TRY(Ordered fine, ordered(finer(k), points_at(k), level));
        RELIEF_TRY(const StepRules rules, step_rules(level.unsplit.mesh, level.tags, level.split));
        RELIEF_TRY(Points coarse,
                   lifted({level.unsplit.mesh, rules}, std::move(fine.points), scheme_));
        coarser_points_.push_back(std::move(coarse));
    }
    return points_at(levels_.size());
}

Result<std::unique_ptr<FoundLevel>> MeshDescent::found(
    const std::vector<std::size_t>& choice) const {
    auto level = std::make_unique<FoundLevel>();
    level->split = split_at(levels_.size());
    RELIEF_TRY(level->unsplit, recognition_->unsplit(choice));
    level->tags = coarser_tags(tags_left(), finest_left(), *level, nullptr);
    return level;
}

Result<std::unique_ptr<FoundLevel>> MeshDescent::choose() {
    Choices all(recognition_->components());
    for (std::size_t c = 0; c < all.size(); ++c) {
        all[c].resize(recognition_->ways(c));
        std::iota(all[c].begin(), all[c].end(), std::size_t{0});
    }
    if (most_ways(all) == 1) return found(choice_of(all, 0));
    RELIEF_TRY(const Choices choices, choices_that_go_on(all));
    const std::vector<std::size_t> first = choice_of(choices, 0);
    if (most_ways(choices) > 1 && !points_.empty()) {
        ahead_.reset();
        return nearest(choices);
    }
    if (ahead_ && ahead_->choice == first) return std::move(ahead_->found);
    ahead_.reset();
    return found(first);
}

/// The ways in which a component is a split of what is itself a split. All ways, if there is a
/// component without such a one: then this level is the last.
Result<MeshDescent::Choices> MeshDescent::choices_that_go_on(const Choices& all) {
    const Topology& fine = finest_left();
    Choices uniform(all.size());
    Choices result(all.size());
    for (std::size_t c = 0; c < all.size(); ++c)
        for (const std::size_t way : all[c])
            if (recognition_->is_uniform(c, way)) uniform[c].push_back(way);
    if (any_empty(uniform)) return all;
    for (std::size_t way = 0; way < most_ways(uniform); ++way) {
        ahead_.emplace().choice = choice_of(uniform, way);
        RELIEF_TRY(ahead_->found, found(ahead_->choice));
        const Unsplit& unsplit = ahead_->found->unsplit;
        ahead_->next =
            std::make_unique<const Recognition>(unsplit.mesh, split_at(levels_.size() + 1));
        for (Index f = 0; f < unsplit.mesh.face_count; ++f) {
            if (ahead_->next->ways(ahead_->next->parts().of_face[f]) == 0) continue;
            const Index face = fine.face_of(unsplit.fine[unsplit.mesh.first_of(f)]);
            const Index c = recognition_->parts().of_face[face];
            if (result[c].empty() || result[c].back() != ahead_->choice[c])
                result[c].push_back(ahead_->choice[c]);
        }
    }
    return any_empty(result) ? all : result;
}

/// For each component the way from which subdivision comes nearest.
Result<std::unique_ptr<FoundLevel>> MeshDescent::nearest(const Choices& choices) {
    std::vector<std::size_t> best = choice_of(choices, 0);
    std::vector<double> least(choices.size(), std::numeric_limits<double>::infinity());
    std::optional<Attempt> kept;
    for (std::size_t way = 0; way < most_ways(choices); ++way) {
        RELIEF_TRY(Attempt attempt, attempted(choice_of(choices, way)));
        for (std::size_t c = 0; c < choices.size(); ++c)
            if (attempt.squares[c] < least[c]) {
                least[c] = attempt.squares[c];
                best[c] = attempt.choice[c];
            }
        if (best == attempt.choice) kept = std::move(attempt);
    }
    if (!kept || kept->choice != best) return found(best);
    coarser_points_.push_back(std::move(kept->coarse));
    return std::move(kept->found);
}

Result<MeshDescent::Attempt> MeshDescent::attempted(std::vector<std::size_t> choice) {
    Attempt attempt;
    RELIEF_TRY(attempt.found, found(choice));
    const Topology& coarse = attempt.found->unsplit.mesh;
    RELIEF_TRY(const auto points, points_left());
    RELIEF_TRY(const Ordered fine, ordered(finest_left(), points, *attempt.found));
    RELIEF_TRY(const StepRules rules,
               step_rules(coarse, attempt.found->tags, attempt.found->split));
    const MeshStep<double> step(coarse, rules);
    RELIEF_TRY(attempt.coarse, lifted(step, fine.points, scheme_));
    Points surface(fine.points.size());
    step.apply(attempt.coarse.data(), surface.data(), surface.data() + attempt.coarse.size());
    attempt.squares.assign(choice.size(), 0);
    for (std::size_t k = 0; k < surface.size(); ++k) {
        const Vec3<double> off = fine.points[k] - surface[k];
        const Index face = finest_left().face_of(fine.half_edge[k]);
        attempt.squares[recognition_->parts().of_face[face]] += dot(off, off);
    }
    attempt.choice = std::move(choice);
    return attempt;
}

}  // namespace relief::multires
