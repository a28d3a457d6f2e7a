#include <algorithm>
#include <map>
#include <string>

#include "relief/mesh/walk.h"
#include "relief/multires/mesh_step.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Split;
using mesh::Topology;

bool is_sqrt3(Split split) {
    return split == Split::Sqrt3Odd || split == Split::Sqrt3Even;
}

Error invalid_parameter(std::string what, std::string where) {
    return Error{ErrorCode::InvalidArgument, "invalid_parameter: " + std::move(what),
                 std::move(where)};
}

class Builder {
  public:
    Builder(const Topology& coarse, const MeshTags& tags, Split split, const StepOptions& options)
        : mesh_(coarse), tags_(tags), options_(options), valence_(mesh::valences(coarse)) {
        rules_.split = split;
    }

    Result<StepRules> run() {
        RELIEF_CHECK(check());
        const Index count = mesh_.vertex_count;
        const auto fine = mesh::refined(mesh::counts_of(mesh_), rules_.split);
        rules_.new_count = static_cast<Index>(fine.vertices - count);
        if (rules_.split != Split::Loop)
            rules_.face_points = mesh::face_points(mesh_, rules_.split);
        rules_.kinds = kinds();
        rules_.self = Buffer<double>(count);
        rules_.point = Buffer<double>(count);
        if (has_sharp()) rules_.sharp = tags_.sharp;
        for (Index v = 0; v < count; ++v) RELIEF_CHECK(set_vertex(v));
        if (is_sqrt3(rules_.split)) {
            if (rules_.split == Split::Sqrt3Even) trisect();
        } else {
            add_curves();
            if (has_sharp()) add_darts();
        }
        if (rules_.split == Split::CatmullClark) find_stiff();
        std::stable_sort(rules_.points.begin(), rules_.points.end(),
                         [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
        return std::move(rules_);
    }

  private:
    [[nodiscard]] bool has_sharp() const {
        return std::find(tags_.sharp.begin(), tags_.sharp.end(), 1) != tags_.sharp.end();
    }

    Status check() const {
        if (rules_.split != Split::CatmullClark && mesh_.sides != 3)
            return Error{ErrorCode::BadInput,
                         "not_triangles: Loop and sqrt(3) subdivision need triangles", "mesh"};
        if (!tags_.sharp.empty() && tags_.sharp.size() != mesh_.edge_count)
            return invalid_parameter("tags need one number an edge", "tags");
        if (!tags_.corner.empty() && tags_.corner.size() != mesh_.vertex_count)
            return invalid_parameter("tags need one number a vertex", "tags");
        if (!is_sqrt3(rules_.split)) return {};
        if (options_.alpha && !(*options_.alpha >= 0 && *options_.alpha < 2.0 / 3))
            return invalid_parameter("alpha must be from 0 to below 2/3", "alpha");
        if (!has_sharp()) return {};
        for (Index h = 0; h < mesh_.half_edge_count(); ++h)
            if (!mesh_.on_boundary(h) && tags_.is_sharp(mesh_, h))
                return invalid_parameter(
                    "sqrt(3) subdivision has no sharp edges inside the surface; cut the mesh "
                    "along them or use Loop subdivision",
                    "edge from vertex " + std::to_string(mesh_.origin[h]) + " to " +
                        std::to_string(mesh_.target(h)));
        return {};
    }

    [[nodiscard]] Buffer<VertexKind> kinds() const {
        std::vector<std::uint8_t> sharp_edges(mesh_.vertex_count, 0);
        const auto count = [&](Index v) {
            if (sharp_edges[v] < 3) ++sharp_edges[v];
        };
        mesh::each_edge(mesh_, [&](Index h, Index next, Index) {
            if (!tags_.is_sharp(mesh_, h)) return;
            count(mesh_.origin[h]);
            count(mesh_.origin[next]);
        });
        Buffer<VertexKind> result(mesh_.vertex_count);
        for (Index v = 0; v < mesh_.vertex_count; ++v) {
            const bool corner = !tags_.corner.empty() && tags_.corner[v] != 0;
            result[v] = corner ? VertexKind::Corner : static_cast<VertexKind>(sharp_edges[v]);
        }
        return result;
    }

    void set(Index v, double self, double point) {
        rules_.self[v] = self;
        rules_.point[v] = point;
    }

    Status set_vertex(Index v) {
        const VertexKind kind = rules_.kinds[v];
        const Index n = valence_[v];
        if (kind == VertexKind::Corner) {
            set(v, 1, 0);
            return {};
        }
        if (is_sqrt3(rules_.split)) return set_sqrt3(v, n, kind);
        if (kind == VertexKind::Crease) {
            set(v, rules::kDyadicCurve.self, 0);
            return {};
        }
        const rules::SmoothRule rule =
            rules_.split == Split::Loop ? rules::loop_smooth(n) : rules::catmull_clark_smooth(n);
        set(v, rule.self, kind == VertexKind::Smooth ? rule.edge : 0);  // darts: later
        return {};
    }

    Status set_sqrt3(Index v, Index n, VertexKind kind) {
        if (kind != VertexKind::Smooth) {
            const bool moves = rules_.split == Split::Sqrt3Even;
            set(v, moves ? rules::kTernaryCurve.self : 1, 0);
            return {};
        }
        if (n < 3)
            return Error{ErrorCode::BadInput,
                         "unsupported_valence: a vertex inside has two edges; sqrt(3) subdivision "
                         "can not be reversed there",
                         "vertex " + std::to_string(v)};
        const rules::SmoothRule rule = rules::sqrt3_smooth(n, alpha(n));
        set(v, rule.self, rule.face);
        return {};
    }

    [[nodiscard]] double alpha(Index n) const {
        return options_.alpha ? *options_.alpha : rules::sqrt3_alpha(n);
    }

    /// Loop and Catmull-Clark: creases look at the points of their two sharp edges.
    void add_curves() {
        mesh::each_edge(mesh_, [&](Index h, Index next, Index) {
            if (!tags_.is_sharp(mesh_, h)) return;
            for (const Index v : {mesh_.origin[h], mesh_.origin[next]})
                if (rules_.kinds[v] == VertexKind::Crease)
                    rules_.points.push_back({v, mesh_.edge[h], rules::kDyadicCurve.point});
        });
    }

    void add_darts() {
        const auto out = mesh::outgoing(mesh_);
        std::map<Index, rules::DartRule> loop;
        for (Index v = 0; v < mesh_.vertex_count; ++v) {
            if (rules_.kinds[v] != VertexKind::Dart) continue;
            Index sharp = out[v];
            while (!tags_.is_sharp(mesh_, sharp)) sharp = mesh::rotated(mesh_, sharp);
            if (rules_.split == Split::CatmullClark) {
                add_quad_dart(v, sharp);
                continue;
            }
            const auto [found, is_new] = loop.try_emplace(valence_[v]);
            if (is_new) found->second = rules::loop_dart(valence_[v]);
            rules_.self[v] = found->second.self;
            Index h = sharp;
            for (const double weight : found->second.edges) {
                rules_.points.push_back({v, mesh_.edge[h], weight});
                h = mesh::rotated(mesh_, h);
            }
        }
    }

    /// n^2 K is the sum of face points and of edge sums: 4 E - F - F' or, sharp, 2 E.
    void add_quad_dart(Index v, Index sharp) {
        const double share = -rules::catmull_clark_smooth(valence_[v]).face;
        Index h = sharp;
        do {
            const bool is_sharp = h == sharp;
            rules_.points.push_back({v, mesh_.edge[h], (is_sharp ? 2 : 4) * share});
            const Index f = mesh_.face_of(h);
            const bool beside = is_sharp || mesh::rotated(mesh_, h) == sharp;
            rules_.points.push_back(
                {v, rules_.face_points[f] - mesh_.vertex_count, beside ? 0 : -share});
            h = mesh::rotated(mesh_, h);
        } while (h != sharp);
    }

    void trisect() {
        Buffer<Index> before(mesh_.vertex_count);
        Buffer<Index> after(mesh_.vertex_count);
        mesh::each_half_edge(mesh_, [&](Index, Index h, Index next, Index) {
            if (!mesh_.on_boundary(h)) return;
            before[mesh_.origin[next]] = mesh_.origin[h];
            after[mesh_.origin[h]] = mesh_.origin[next];
        });
        mesh::each_half_edge(mesh_, [&](Index f, Index h, Index next, Index prev) {
            if (!mesh_.on_boundary(h)) return;
            const Index a = mesh_.origin[h];
            const Index b = mesh_.origin[next];
            const Index point = rules_.face_points[f] - mesh_.vertex_count;
            const auto is_corner = [&](Index v) { return rules_.kinds[v] == VertexKind::Corner; };
            rules_.trisections.push_back(
                {point, a, b, before[a], after[b], is_corner(a), is_corner(b)});
            if (!is_corner(a)) rules_.points.push_back({a, point, rules::kTernaryCurve.point});
            if (!is_corner(b)) rules_.points.push_back({b, point + 1, rules::kTernaryCurve.point});
            add_apex(mesh_.origin[prev], a, b);
        });
    }

    /// Instead of the face's point, its apex looks at the ends of the boundary edge.
    void add_apex(Index apex, Index a, Index b) {
        if (rules_.kinds[apex] != VertexKind::Smooth) return;
        const Index n = valence_[apex];
        const double weight = alpha(n) / (2.0 * n);
        rules_.self[apex] += weight;
        rules_.apexes.push_back({apex, a, b, weight});
    }

    void find_stiff() {
        StiffVertices& stiff = rules_.stiff;
        std::vector<Index> place(mesh_.vertex_count, kNone);
        for (Index v = 0; v < mesh_.vertex_count; ++v) {
            const bool smooth = rules_.kinds[v] <= VertexKind::Dart;
            if (!smooth || valence_[v] != 3) continue;
            place[v] = static_cast<Index>(stiff.size());
            stiff.vertices.push_back(v);
        }
        if (stiff.size() == 0) return;
        const auto out = mesh::outgoing(mesh_);
        for (const Index v : stiff.vertices) {
            Index h = out[v];
            auto& neighbours = stiff.neighbours.emplace_back();
            for (Index& neighbour : neighbours) {
                neighbour = place[mesh_.target(h)];
                h = mesh::rotated(mesh_, h);
            }
        }
        find_alternating(stiff);
    }

    /// Two colours for clusters that touch nothing else.
    static void find_alternating(StiffVertices& stiff) {
        std::vector<std::int8_t> signs(stiff.size(), 0);
        for (std::size_t seed = 0; seed < stiff.size(); ++seed) {
            if (signs[seed] != 0) continue;
            StiffVertices::Alternating component;
            bool alternates = true;
            signs[seed] = 1;
            component.places.push_back(static_cast<Index>(seed));
            for (std::size_t k = 0; k < component.places.size(); ++k) {
                const Index v = component.places[k];
                for (const Index w : stiff.neighbours[v]) {
                    alternates = alternates && w != kNone && signs[w] != signs[v];
                    if (w == kNone || signs[w] != 0) continue;
                    signs[w] = static_cast<std::int8_t>(-signs[v]);
                    component.places.push_back(w);
                }
            }
            if (!alternates) continue;
            for (const Index v : component.places) component.signs.push_back(signs[v]);
            stiff.alternating.push_back(std::move(component));
        }
    }

    const Topology& mesh_;
    const MeshTags& tags_;
    const StepOptions& options_;
    Buffer<Index> valence_;
    StepRules rules_;
};

}  // namespace

void tag_boundary_corners(const Topology& mesh, MeshTags& tags) {
    tags.corner.resize(mesh.vertex_count, 0);
    const auto out = mesh::outgoing(mesh);
    for (Index v = 0; v < mesh.vertex_count; ++v)
        if (mesh.on_boundary(out[v]) && mesh::rotated(mesh, out[v]) == kNone) tags.corner[v] = 1;
}

MeshTags refined(const MeshTags& tags, const Topology& coarse, const Topology& fine, Split split) {
    MeshTags result;
    if (!tags.corner.empty()) {
        result.corner.assign(fine.vertex_count, 0);
        std::copy(tags.corner.begin(), tags.corner.end(), result.corner.begin());
    }
    if (tags.sharp.empty() || is_sqrt3(split)) return result;
    result.sharp.assign(fine.edge_count, 0);
    for (Index h = 0; h < coarse.half_edge_count(); ++h)
        if (tags.sharp[coarse.edge[h]] != 0)
            for (const Index half : mesh::halves(coarse, split, h))
                result.sharp[fine.edge[half]] = 1;
    return result;
}

Result<StepRules> step_rules(const Topology& coarse, const MeshTags& tags, Split split,
                             const StepOptions& options) {
    return Builder(coarse, tags, split, options).run();
}

}  // namespace relief::multires
