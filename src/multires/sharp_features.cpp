#include "multires/sharp_features.h"

#include <algorithm>
#include <cmath>

#include "relief/mesh/walk.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::Split;
using mesh::Topology;

bool is_sqrt3(Split split) {
    return split == Split::Sqrt3Odd || split == Split::Sqrt3Even;
}

/// One step later.
double softened(double sharpness) {
    return sharpness > 1 ? sharpness - 1 : 0;
}

/// A sharp edge, seen from one of its ends.
struct Spoke {
    Index centre = 0;
    Index end = 0;
    double sharpness = 0;
};

class Masks {
  public:
    Masks(const Topology& coarse, const SharpFeatures& features, Split split, ForwardRules& rules)
        : coarse_(coarse), features_(features), split_(split), rules_(rules) {}

    void run() {
        find_spokes();
        if (!is_sqrt3(split_))
            for (const SharpFeatures::Edge& edge : features_.edges) add_middle(edge);
        else if (split_ == Split::Sqrt3Even)
            add_thirds();
        auto spoke = spokes_.cbegin();
        auto vertex = features_.vertices.cbegin();
        while (spoke != spokes_.cend() || vertex != features_.vertices.cend()) {
            const bool by_itself =
                spoke == spokes_.cend() ||
                (vertex != features_.vertices.cend() && vertex->vertex <= spoke->centre);
            const Index v = by_itself ? vertex->vertex : spoke->centre;
            const auto end =
                std::find_if(spoke, spokes_.cend(), [&](const Spoke& s) { return s.centre != v; });
            const double own = by_itself ? (vertex++)->sharpness : 0;
            add_vertex(v, own, std::span(spoke, end));
            spoke = end;
        }
    }

  private:
    void find_spokes() {
        for (const auto& [h, sharpness] : features_.edges) {
            const Index a = coarse_.origin[h];
            const Index b = coarse_.target(h);
            spokes_.push_back({a, b, sharpness});
            spokes_.push_back({b, a, sharpness});
        }
        std::stable_sort(spokes_.begin(), spokes_.end(),
                         [](const Spoke& a, const Spoke& b) { return a.centre < b.centre; });
    }

    void add_term(Index coarse, double weight) { rules_.terms.push_back({coarse, weight}); }
    void end_mask(Index fine, double smooth) {
        rules_.masks.push_back({fine, rules_.terms.size(), smooth});
    }

    void add_middle(const SharpFeatures::Edge& edge) {
        const double share = std::min(edge.sharpness, 1.0);
        add_term(coarse_.origin[edge.half_edge], share * rules::kSharpEdgeEnd);
        add_term(coarse_.target(edge.half_edge), share * rules::kSharpEdgeEnd);
        end_mask(coarse_.vertex_count + coarse_.edge[edge.half_edge], 1 - share);
    }

    /// The points of trisected boundary edges.
    void add_thirds() {
        const mesh::FacePoints points = mesh::face_points(coarse_, split_);
        for (const auto& [h, sharpness] : features_.edges) {
            const Index p = points[h / 3];
            rules_.trisected.push_back(h / 3);
            add_third(p, coarse_.origin[h], coarse_.target(h));
            add_third(p + 1, coarse_.target(h), coarse_.origin[h]);
        }
    }

    /// The point next to a of the edge between a and b.
    void add_third(Index point, Index a, Index b) {
        if (is_corner(a)) {
            add_term(a, rules::kThirdOfCorner);
            add_term(b, rules::kThirdOfCornerFar);
        } else {
            add_term(a, rules::kThirdNear);
            add_term(b, rules::kThirdFar);
            add_term(beyond(a, b), rules::kThirdBeyond);
        }
        end_mask(point, 0);
    }

    [[nodiscard]] bool is_corner(Index v) const {
        const auto found = std::lower_bound(
            features_.vertices.begin(), features_.vertices.end(), v,
            [](const SharpFeatures::Vertex& vertex, Index w) { return vertex.vertex < w; });
        return found != features_.vertices.end() && found->vertex == v &&
               std::isinf(found->sharpness);
    }

    /// The other neighbour of a, besides b, on the boundary.
    [[nodiscard]] Index beyond(Index a, Index b) const {
        const auto found = std::lower_bound(spokes_.begin(), spokes_.end(), a,
                                            [](const Spoke& s, Index v) { return s.centre < v; });
        return found->end != b ? found->end : (found + 1)->end;
    }

    /// The curves that a vertex is on, when `age` steps have passed.
    struct State {
        VertexKind kind = VertexKind::Smooth;
        std::vector<Index> ends;
    };
    [[nodiscard]] static State state(double own, std::span<const Spoke> spokes, int age) {
        const auto now = [&](double s) { return age == 0 ? s : softened(s); };
        State result;
        for (const Spoke& spoke : spokes)
            if (now(spoke.sharpness) > 0) result.ends.push_back(spoke.end);
        result.kind = now(own) > 0
                          ? VertexKind::Corner
                          : static_cast<VertexKind>(std::min<std::size_t>(result.ends.size(), 3));
        return result;
    }

    /// How much of a rule that ends with this step is left: the mean of the sharpness that ends.
    [[nodiscard]] static double share_of_ending(double own, std::span<const Spoke> spokes) {
        double sum = 0;
        int count = 0;
        const auto add = [&](double s) {
            if (s <= 0 || softened(s) > 0) return;
            sum += s;
            ++count;
        };
        add(own);
        for (const Spoke& spoke : spokes) add(spoke.sharpness);
        return count == 0 ? 0 : std::min(sum / count, 1.0);
    }

    void add_vertex(Index v, double own, std::span<const Spoke> spokes) {
        const State before = state(own, spokes, 0);
        if (before.kind < VertexKind::Crease) return;
        const State after = state(own, spokes, 1);
        const double share = after.kind == before.kind ? 1 : share_of_ending(own, spokes);
        double smooth = add_terms(v, before, share);
        if (share < 1) smooth += add_terms(v, after, 1 - share);
        end_mask(v, smooth);
    }

    /// Returns the share of the smooth rule.
    double add_terms(Index v, const State& state, double share) {
        if (state.kind < VertexKind::Crease) return share;
        const bool stays = state.kind == VertexKind::Corner || split_ == Split::Sqrt3Odd;
        const rules::CurveRule mask = stays                        ? rules::CurveRule{1, 0}
                                      : split_ == Split::Sqrt3Even ? rules::kTernaryMask
                                                                   : rules::kDyadicMask;
        add_term(v, share * mask.self);
        if (!stays)
            for (const Index end : state.ends) add_term(end, share * mask.point);
        return 0;
    }

    const Topology& coarse_;
    const SharpFeatures& features_;
    Split split_;
    ForwardRules& rules_;
    std::vector<Spoke> spokes_;
};

}  // namespace

SharpFeatures sharp_features(const Topology& mesh, const Sharpness& sharpness) {
    SharpFeatures features;
    add_boundary(mesh, features);
    if (!sharpness.edges.empty())
        mesh::each_edge(mesh, [&](Index h, Index, Index) {
            const double s = sharpness.edges[mesh.edge[h]];
            if (!mesh.on_boundary(h) && s > 0) features.edges.push_back({h, s});
        });
    for (Index v = 0; v < sharpness.vertices.size(); ++v)
        if (sharpness.vertices[v] > 0) features.vertices.push_back({v, sharpness.vertices[v]});
    return features;
}

void add_boundary(const Topology& mesh, SharpFeatures& features) {
    if (mesh::counts_of(mesh).boundary_edges == 0) return;
    for (Index h = 0; h < mesh.half_edge_count(); ++h)
        if (mesh.on_boundary(h)) features.edges.push_back({h, HUGE_VAL});
}

SharpFeatures refined(const SharpFeatures& features, const Topology& coarse, Split split) {
    SharpFeatures result;
    for (const auto& [v, sharpness] : features.vertices)
        if (softened(sharpness) > 0) result.vertices.push_back({v, softened(sharpness)});
    if (is_sqrt3(split)) return result;
    for (const auto& [h, sharpness] : features.edges)
        if (softened(sharpness) > 0)
            for (const Index half : mesh::halves(coarse, split, h))
                result.edges.push_back({half, softened(sharpness)});
    return result;
}

void set_masks(const Topology& coarse, const SharpFeatures& features, Split split,
               ForwardRules& rules) {
    rules.masks.clear();
    rules.terms.clear();
    rules.trisected.clear();
    Masks(coarse, features, split, rules).run();
}

}  // namespace relief::multires
