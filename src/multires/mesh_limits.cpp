#include <array>
#include <cmath>
#include <utility>

#include "multires/mesh_points.h"
#include "relief/multires/subdivide.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Topology;

constexpr double kPi = 3.14159265358979323846;

template <class T>
class Limits {
  public:
    Limits(const Topology& mesh, std::span<const Vec3<T>> points, const StepRules& rules,
           MeshScheme scheme)
        : mesh_(mesh), points_(points), rules_(rules), scheme_(scheme) {}

    [[nodiscard]] std::vector<Vec3<T>> places() const {
        const auto valence = mesh::valences(mesh_);
        std::vector<Vec3<T>> curve(points_.size());   // of the neighbours along sharp edges
        std::vector<Vec3<T>> edges(points_.size());   // of all neighbours
        std::vector<Vec3<T>> across(points_.size());  // of the corners across quads
        mesh::each_half_edge(mesh_, [&](Index, Index h, Index next, Index) {
            if (scheme_ == MeshScheme::CatmullClark)
                across[mesh_.origin[h]] += points_[mesh_.target(next)];
            if (!mesh_.is_first(h)) return;
            const Index a = mesh_.origin[h];
            const Index b = mesh_.origin[next];
            edges[a] += points_[b];
            edges[b] += points_[a];
            if (!is_sharp(rules_, mesh_, h)) return;
            curve[a] += points_[b];
            curve[b] += points_[a];
        });
        std::vector<Vec3<T>> result(points_.begin(), points_.end());
        for (Index v = 0; v < points_.size(); ++v) {
            const VertexKind kind = rules_.kinds[v];
            if (kind == VertexKind::Corner) continue;
            if (kind == VertexKind::Crease)
                result[v] = T{1} / 6 * (T{4} * points_[v] + curve[v]);
            else
                result[v] = smooth(v, valence[v], edges[v], across[v]);
        }
        return result;
    }

    /// places: where all vertices go.
    [[nodiscard]] std::vector<Vec3<T>> normals(const std::vector<Vec3<T>>& places) const {
        std::vector<Vec3<T>> result(points_.size());
        const auto out = mesh::outgoing(mesh_);
        for (Index f = 0; f < mesh_.face_count; ++f) {
            const auto corners = mesh_.corners(f);
            Vec3<T> normal;
            for (std::size_t k = 1; k + 1 < corners.size(); ++k)
                normal += cross(places[corners[k]] - places[corners[0]],
                                places[corners[k + 1]] - places[corners[0]]);
            for (const Index v : corners) result[v] += normal;
        }
        for (Index v = 0; v < points_.size(); ++v) {
            if (rules_.kinds[v] == VertexKind::Smooth) result[v] = smooth_normal(out[v]);
            const T size = length(result[v]);
            if (size > 0) result[v] = T{1} / size * result[v];
        }
        return result;
    }

  private:
    [[nodiscard]] Vec3<T> smooth(Index v, Index n, const Vec3<T>& edges,
                                 const Vec3<T>& across) const {
        const auto count = static_cast<T>(n);
        if (scheme_ == MeshScheme::CatmullClark)
            return T{1} / (count * (count + 5)) *
                   (count * count * points_[v] + T{4} * edges + across);
        T each = 0;  // of a neighbour
        if (scheme_ == MeshScheme::Loop) {
            each = static_cast<T>(1 / (3 / (8 * rules::loop_alpha(n)) + n));
        } else {
            const double alpha = rules::sqrt3_alpha(n);
            each = static_cast<T>(3 * alpha / (1 + 3 * alpha) / n);
        }
        return (1 - count * each) * points_[v] + each * edges;
    }

    /// From the two tangents of the ring's first frequency.
    [[nodiscard]] Vec3<T> smooth_normal(Index start) const {
        std::vector<Index> ring;
        Index h = start;
        do {
            ring.push_back(h);
            h = mesh::rotated(mesh_, h);
        } while (h != start);
        const auto n = static_cast<double>(ring.size());
        const bool quads = scheme_ == MeshScheme::CatmullClark;
        const double c = std::cos(2 * kPi / n);
        const double of_edges = quads ? 1 + c + std::cos(kPi / n) * std::sqrt(2 * (9 + c)) : 1;
        std::array<Vec3<T>, 2> tangents;
        for (std::size_t k = 0; k < ring.size(); ++k) {
            const double angle = 2 * kPi * static_cast<double>(k) / n;
            const double next = 2 * kPi * static_cast<double>(k + 1) / n;
            const std::array<std::pair<double, double>, 2> waves{
                std::pair{std::cos(angle), std::cos(next)}, {std::sin(angle), std::sin(next)}};
            for (std::size_t t = 0; t < 2; ++t) {
                tangents[t] +=
                    static_cast<T>(of_edges * waves[t].first) * points_[mesh_.target(ring[k])];
                if (quads)
                    tangents[t] += static_cast<T>(waves[t].first + waves[t].second) *
                                   points_[mesh_.target(mesh_.next(ring[k]))];
            }
        }
        return cross(tangents[0], tangents[1]);
    }

    const Topology& mesh_;
    std::span<const Vec3<T>> points_;
    const StepRules& rules_;
    MeshScheme scheme_;
};

/// visit(limits, how many vertices are asked for): of the mesh, or of its first subdivision.
template <class T, class Visit>
Result<std::vector<Vec3<T>>> with_limits(const Topology& mesh, std::span<const Vec3<T>> points,
                                         const Sharpness& sharpness, MeshScheme scheme,
                                         Visit visit) {
    const auto all_quads = [&] { return scheme != MeshScheme::CatmullClark || mesh.sides == 4; };
    // Sharpness that ends some time is none; what is for ever is the same at every step.
    const MeshTags tags = tags_of(sharpness);
    const mesh::Split split = split_of(scheme, 0);
    if (all_quads()) {
        RELIEF_TRY(const StepRules rules, step_rules(mesh, tags, split));
        return visit(Limits<T>(mesh, points, rules, scheme), points.size());
    }
    SubdividedMesh<T> once;
    RELIEF_TRY(once.mesh, mesh::build(mesh::faces_of(mesh), mesh.vertex_count));
    once.arrays.emplace_back(points.begin(), points.end());
    once.sharpness = sharpness;
    RELIEF_TRY(once, subdivide(std::move(once), {.scheme = scheme}, 1));
    RELIEF_TRY(const StepRules rules, step_rules(once.mesh, tags_of(once.sharpness), split));
    return visit(Limits<T>(once.mesh, once.arrays[0], rules, scheme), points.size());
}

}  // namespace

template <class T>
Result<std::vector<Vec3<T>>> limit_points(const Topology& mesh, std::span<const Vec3<T>> points,
                                          const Sharpness& sharpness, MeshScheme scheme) {
    return with_limits<T>(mesh, points, sharpness, scheme,
                          [](const Limits<T>& limits, std::size_t count) {
                              auto places = limits.places();
                              places.resize(count);
                              return places;
                          });
}

template <class T>
Result<std::vector<Vec3<T>>> limit_normals(const Topology& mesh, std::span<const Vec3<T>> points,
                                           const Sharpness& sharpness, MeshScheme scheme) {
    return with_limits<T>(mesh, points, sharpness, scheme,
                          [](const Limits<T>& limits, std::size_t count) {
                              auto normals = limits.normals(limits.places());
                              normals.resize(count);
                              return normals;
                          });
}

template Result<std::vector<Vec3<float>>> limit_points(const Topology&,
                                                       std::span<const Vec3<float>>,
                                                       const Sharpness&, MeshScheme);
template Result<std::vector<Vec3<double>>> limit_points(const Topology&,
                                                        std::span<const Vec3<double>>,
                                                        const Sharpness&, MeshScheme);
template Result<std::vector<Vec3<float>>> limit_normals(const Topology&,
                                                        std::span<const Vec3<float>>,
                                                        const Sharpness&, MeshScheme);
template Result<std::vector<Vec3<double>>> limit_normals(const Topology&,
                                                         std::span<const Vec3<double>>,
                                                         const Sharpness&, MeshScheme);

}  // namespace relief::multires
