#include "relief/multires/subdivider.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "multires/forward_points.h"
#include "multires/sharp_features.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::Split;
using mesh::Topology;
using rules::RingRule;

Error invalid_parameter(std::string what, std::string where) {
    return {ErrorCode::InvalidArgument, "invalid_parameter: " + std::move(what), std::move(where)};
}

Status check(const Topology& mesh, const Sharpness& sharpness, const MeshSpec& spec) {
    if ((!sharpness.edges.empty() && sharpness.edges.size() != mesh.edge_count) ||
        (!sharpness.vertices.empty() && sharpness.vertices.size() != mesh.vertex_count))
        return invalid_parameter("it needs one number an edge and a vertex", "sharpness");
    const auto good = [](double s) { return s >= 0; };  // not for NaN
    if (!std::all_of(sharpness.edges.begin(), sharpness.edges.end(), good) ||
        !std::all_of(sharpness.vertices.begin(), sharpness.vertices.end(), good))
        return invalid_parameter("it is a number from 0 on", "sharpness");
    if (spec.scheme != MeshScheme::Sqrt3) return {};
    if (spec.alpha && !(*spec.alpha >= 0 && *spec.alpha < 2.0 / 3))
        return invalid_parameter("alpha must be from 0 to below 2/3", "alpha");
    for (Index h = 0; !sharpness.edges.empty() && h < mesh.half_edge_count(); ++h)
        if (!mesh.on_boundary(h) && sharpness.edges[mesh.edge[h]] > 0)
            return invalid_parameter(
                "sqrt(3) subdivision has no creases inside the surface; cut the mesh along them or "
                "use Loop subdivision",
                "sharpness");
    return {};
}

/// The smooth rules of one scheme, by valence.
class SmoothRules {
  public:
    explicit SmoothRules(const MeshSpec& spec) : spec_(spec) {}

    [[nodiscard]] RingRule regular() const {
        return made(spec_.scheme == MeshScheme::CatmullClark ? 4 : 6);
    }

    /// Those of all vertices.
    void set(const Topology& mesh, std::vector<RingRule>& rules) {
        const Buffer<Index> valences = mesh::valences(mesh);
        rules.clear();
        for (Index v = 0; v < mesh.vertex_count; ++v) rules.push_back(rule(valences[v]));
    }

    /// Those of the first vertices of `mesh` from those of `before`, one step earlier.
    void pass_on(const Topology& before, const std::vector<RingRule>& rules_before,
                 const Topology& mesh, std::vector<RingRule>& rules) {
        rules = rules_before;
        if (before.sides == mesh.sides) return;
        rules.resize(before.vertex_count + before.edge_count, regular());
        for (Index f = 0; f < before.face_count; ++f) rules.push_back(rule(before.size_of(f)));
    }

    /// The point that an odd sqrt(3) step puts into a face with m boundary edges has 6 - m edges,
    /// until the even step that follows. What its rule is more than the regular one becomes a mask.
    void add_apexes(const Topology& mesh, const SharpFeatures& features, ForwardRules& rules) {
        if (rules.others.ring == 0) return;  // alpha = 0: nothing moves
        std::vector<Index> apexes;
        for (const auto& edge : features.edges)
            apexes.push_back(mesh.origin[mesh.prev(edge.half_edge)]);
        std::sort(apexes.begin(), apexes.end());
        for (auto apex = apexes.begin(); apex != apexes.end();) {
            const auto end = std::upper_bound(apex, apexes.end(), *apex);
            const RingRule& own = rule(6 - static_cast<Index>(end - apex));
            const double smooth = own.ring / rules.others.ring;
            rules.terms.push_back({*apex, own.self - smooth * rules.others.self});
            rules.masks.push_back({*apex, rules.terms.size(), smooth});
            apex = end;
        }
    }

  private:
    [[nodiscard]] RingRule made(Index n) const {
        if (spec_.scheme == MeshScheme::Loop) return rules::loop_ring(n);
        if (spec_.scheme == MeshScheme::CatmullClark) return rules::catmull_clark_ring(n);
        return rules::sqrt3_ring(n, spec_.alpha ? *spec_.alpha : rules::sqrt3_alpha(n));
    }

    const RingRule& rule(Index n) {
        for (Index k = static_cast<Index>(known_.size()); k <= n; ++k)
            known_.push_back(k < 2 ? RingRule() : made(k));
        return known_[n];
    }

    MeshSpec spec_;
    std::vector<RingRule> known_;
};

}  // namespace

Status Subdivider::prepare(const Topology& base, const Sharpness& sharpness, const MeshSpec& spec,
                           int steps) {
    if (steps < 1) return invalid_parameter("there must be one step or more", "steps");
    RELIEF_CHECK(check(base, sharpness, spec));
    RELIEF_CHECK(spec.check_steps(base, steps));
    const auto count = static_cast<std::size_t>(steps);
    base_ = &base;
    has_sharp_edges_ = !sharpness.edges.empty();
    has_sharp_vertices_ = !sharpness.vertices.empty();
    left_ = sharp_features(base, sharpness);
    splits_.clear();
    levels_.resize(std::max(levels_.size(), count - 1));
    rules_.resize(std::max(rules_.size(), count));
    SmoothRules smooth(spec);
    for (std::size_t step = 0; step < count; ++step) {
        const Topology* const before = step > 0 ? &level(step - 1) : nullptr;
        if (before) RELIEF_CHECK(mesh::refine(*before, splits_.back(), levels_[step - 1]));
        const Topology& coarse = level(step);
        splits_.push_back(spec.split(static_cast<int>(step)));
        RELIEF_CHECK(mesh::check_split(coarse, splits_.back()));
        if (before && spec.scheme == MeshScheme::Sqrt3) add_boundary(coarse, left_);
        ForwardRules& rules = rules_[step];
        rules.others = smooth.regular();
        // Even steps change the valences beside boundaries.
        if (!before || (splits_.front() == Split::Sqrt3Even && step == 1))
            smooth.set(coarse, rules.first);
        else
            smooth.pass_on(*before, rules_[step - 1].first, coarse, rules.first);
        set_masks(coarse, left_, splits_.back(), rules);
        if (before && splits_.back() == Split::Sqrt3Even) smooth.add_apexes(coarse, left_, rules);
        left_ = refined(left_, coarse, splits_.back());
    }
    return {};
}

mesh::MeshCounts Subdivider::counts() const {
    return mesh::refined(mesh::counts_of(level(splits_.size() - 1)), splits_.back());
}

void Subdivider::faces(std::span<Index> corners) const {
    mesh::split_faces(level(splits_.size() - 1), splits_.back(), corners);
}

template <class T>
void Subdivider::points(std::span<const Vec3<T>> base, std::span<Vec3<T>> fine) {
    std::copy(base.begin(), base.end(), fine.begin());
    const std::size_t most = level(splits_.size() - 1).vertex_count;
    sums_.renew(4 * sizeof(T) * most);
    for (std::size_t step = 0; step < splits_.size(); ++step)
        forward_points(level(step), splits_[step], rules_[step], fine.data(),
                       reinterpret_cast<T*>(sums_.data()));
}

Result<Topology> Subdivider::finest() const {
    return mesh::refine(level(splits_.size() - 1), splits_.back());
}

Sharpness Subdivider::sharpness(const Topology& finest) const {
    Sharpness result;
    if (has_sharp_edges_) result.edges.assign(finest.edge_count, 0);
    if (has_sharp_vertices_) result.vertices.assign(finest.vertex_count, 0);
    for (const auto& [h, sharpness] : left_.edges)
        if (has_sharp_edges_ && !finest.on_boundary(h)) result.edges[finest.edge[h]] = sharpness;
    for (const auto& [v, sharpness] : left_.vertices) result.vertices[v] = sharpness;
    return result;
}

template void Subdivider::points(std::span<const Vec3<float>>, std::span<Vec3<float>>);
template void Subdivider::points(std::span<const Vec3<double>>, std::span<Vec3<double>>);

}  // namespace relief::multires
