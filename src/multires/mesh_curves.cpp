#include "multires/mesh_curves.h"

#include <algorithm>

#include "multires/mesh_points.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;

constexpr std::size_t kNoPlace = ~std::size_t{0};
/// Rows reach two neighbours; a closed curve that is folded has these four places away.
constexpr std::size_t kHalfWidth = 4;

}  // namespace

MeshCurves::MeshCurves(const MeshStep<double>& step) {
    const StepRules& rules = step.rules();
    if (rules.split == mesh::Split::Sqrt3Odd) return;  // boundaries stay as they are
    const bool some = std::find(rules.kinds.data(), rules.kinds.data() + rules.kinds.size(),
                                VertexKind::Crease) != rules.kinds.data() + rules.kinds.size();
    if (!some) return;
    order_vertices(step);
    if (rules.split == mesh::Split::Sqrt3Even)
        add_ternary_rows(step);
    else
        add_dyadic_rows(step);
    normal_ = BandedCholesky(vertices_.size(), kHalfWidth);
    for (const Row& row : rows_)
        for (std::size_t i = 0; i < row.weights.size(); ++i)
            for (std::size_t j = 0; j <= i; ++j)
                normal_.add(row.weights[i].vertex, row.weights[j].vertex,
                            row.weights[i].weight * row.weights[j].weight);
    // Rows of old vertices are diagonally dominant, so their squares are positive definite.
    [[maybe_unused]] const bool positive = normal_.factor();
}

/// Along each curve; closed ones from both ends of the first vertex in turn.
void MeshCurves::order_vertices(const MeshStep<double>& step) {
    const mesh::Topology& mesh = step.coarse();
    const Index count = mesh.vertex_count;
    beside_.assign(count, {kNone, kNone});
    mesh::each_edge(mesh, [&](Index h, Index next, Index) {
        if (!is_sharp(step.rules(), mesh, h)) return;
        const auto link = [&](Index v, Index w) {
            if (step.rules().kinds[v] == VertexKind::Crease)
                beside_[v][beside_[v][0] == kNone ? 0 : 1] = w;
        };
        link(mesh.origin[h], mesh.origin[next]);
        link(mesh.origin[next], mesh.origin[h]);
    });
    places_.assign(count, kNoPlace);
    const auto is_free = [&](Index v) { return step.rules().kinds[v] == VertexKind::Crease; };
    // The crease vertices that follow `from`, `v` and so on.
    const auto follow = [&](Index from, Index v) {
        std::vector<Index> chain;
        const Index start = from;
        while (is_free(v) && v != start) {
            chain.push_back(v);
            const Index next = beside_[v][0] == from ? beside_[v][1] : beside_[v][0];
            from = v;
            v = next;
        }
        return std::pair(chain, v == start);
    };
    const auto place = [&](Index v) {
        places_[v] = vertices_.size();
        vertices_.push_back(v);
    };
    for (Index v = 0; v < count; ++v) {
        if (!is_free(v) || places_[v] != kNoPlace) continue;
        auto [ahead, closed] = follow(v, beside_[v][0]);
        if (closed) {
            place(v);
            for (std::size_t i = 0, j = ahead.size(); i < j; ++i) {
                place(ahead[i]);
                if (i < --j) place(ahead[j]);
            }
            continue;
        }
        const auto behind = follow(v, beside_[v][1]).first;
        for (std::size_t k = ahead.size(); k-- > 0;) place(ahead[k]);
        place(v);
        for (const Index w : behind) place(w);
    }
}

void MeshCurves::add_row(bool is_new, Index fine,
                         std::initializer_list<std::pair<Index, double>> weights) {
    Row row{is_new, fine, {}};
    for (const auto& [v, weight] : weights)
        if (v != kNone && places_[v] != kNoPlace) row.weights.push_back({places_[v], weight});
    if (!row.weights.empty()) rows_.push_back(std::move(row));
}

void MeshCurves::add_old_row(Index v, const rules::CurveRule& mask) {
    add_row(false, v, {{v, mask.self}, {beside_[v][0], mask.point}, {beside_[v][1], mask.point}});
}

void MeshCurves::add_dyadic_rows(const MeshStep<double>& step) {
    const mesh::Topology& mesh = step.coarse();
    for (const Index v : vertices_) add_old_row(v, rules::kDyadicMask);
    mesh::each_edge(mesh, [&](Index h, Index next, Index) {
        if (is_sharp(step.rules(), mesh, h))
            add_row(true, mesh.edge[h],
                    {{mesh.origin[h], rules::kSharpEdgeEnd},
                     {mesh.origin[next], rules::kSharpEdgeEnd}});
    });
}

void MeshCurves::add_ternary_rows(const MeshStep<double>& step) {
    for (const Index v : vertices_) add_old_row(v, rules::kTernaryMask);
    const auto add_near = [&](Index point, Index near, Index far, Index beyond, bool corner) {
        if (corner)
            return add_row(true, point,
                           {{near, rules::kThirdOfCorner}, {far, rules::kThirdOfCornerFar}});
        add_row(
            true, point,
            {{near, rules::kThirdNear}, {far, rules::kThirdFar}, {beyond, rules::kThirdBeyond}});
    };
    for (const Trisection& third : step.rules().trisections) {
        add_near(third.point, third.from, third.to, third.before, third.from_corner);
        add_near(third.point + 1, third.to, third.from, third.after, third.to_corner);
    }
}

void MeshCurves::fit(const Vec3<double>* old, const Vec3<double>* fresh, Vec3<double>* out) const {
    std::vector<Vec3<double>> x(vertices_.size());
    for (const Row& row : rows_) {
        const Vec3<double>& residual = row.is_new ? fresh[row.fine] : old[row.fine];
        for (const Weight& w : row.weights) x[w.vertex] += w.weight * residual;
    }
    normal_.solve(x.data());
    for (std::size_t k = 0; k < x.size(); ++k) out[vertices_[k]] = x[k];
}

}  // namespace relief::multires
