#include "relief/multires/subdivide.h"

#include <algorithm>
#include <array>

#include "relief/mesh/walk.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Split;
using mesh::Topology;

double sharpness_of(const Sharpness& sharpness, const Topology& mesh, Index h) {
    if (mesh.on_boundary(h)) return HUGE_VAL;
    return sharpness.edges.empty() ? 0 : sharpness.edges[mesh.edge[h]];
}

/// One step later.
double softened(double sharpness) {
    return sharpness > 1 ? sharpness - 1 : 0;
}

Status check(const Topology& mesh, const Sharpness& sharpness, MeshScheme scheme) {
    const auto refuse = [](std::string what) {
        return Error{ErrorCode::InvalidArgument, "invalid_parameter: " + std::move(what),
                     "sharpness"};
    };
    if ((!sharpness.edges.empty() && sharpness.edges.size() != mesh.edge_count) ||
        (!sharpness.vertices.empty() && sharpness.vertices.size() != mesh.vertex_count))
        return refuse("it needs one number an edge and a vertex");
    const auto good = [](double s) { return s >= 0; };  // not for NaN
    if (!std::all_of(sharpness.edges.begin(), sharpness.edges.end(), good) ||
        !std::all_of(sharpness.vertices.begin(), sharpness.vertices.end(), good))
        return refuse("it is a number from 0 on");
    if (scheme != MeshScheme::Sqrt3) return {};
    for (Index h = 0; h < mesh.half_edge_count(); ++h)
        if (!mesh.on_boundary(h) && sharpness_of(sharpness, mesh, h) > 0)
            return refuse(
                "sqrt(3) subdivision has no creases inside the surface; cut the mesh along them or "
                "use Loop subdivision");
    return {};
}

/// The vertices that have a crease or are sharp themselves, and the sharp edges around them.
class SharpVertices {
  public:
    struct Spoke {
        Index target = 0;
        double sharpness = 0;
    };
    struct Vertex {
        Index vertex = 0;
        double sharpness = 0;
        std::vector<Spoke> spokes;
    };

    SharpVertices(const Topology& mesh, const Sharpness& sharpness) {
        std::vector<Index> place(mesh.vertex_count, kNone);
        const auto at = [&](Index v) -> Vertex& {
            if (place[v] == kNone) {
                place[v] = static_cast<Index>(vertices_.size());
                vertices_.push_back({v, 0, {}});
            }
            return vertices_[place[v]];
        };
        for (Index v = 0; v < sharpness.vertices.size(); ++v)
            if (sharpness.vertices[v] > 0) at(v).sharpness = sharpness.vertices[v];
        if (!sharpness.edges.empty())
            mesh::each_edge(mesh, [&](Index h, Index next, Index) {
                if (mesh.on_boundary(h) || sharpness.edges[mesh.edge[h]] <= 0) return;
                at(mesh.origin[h]);
                at(mesh.origin[next]);
            });
        if (vertices_.empty()) return;
        mesh::each_edge(mesh, [&](Index h, Index next, Index) {
            const double s = sharpness_of(sharpness, mesh, h);
            if (s <= 0) return;
            const Index a = mesh.origin[h];
            const Index b = mesh.origin[next];
            if (place[a] != kNone) at(a).spokes.push_back({b, s});
            if (place[b] != kNone) at(b).spokes.push_back({a, s});
        });
    }

    [[nodiscard]] const std::vector<Vertex>& all() const { return vertices_; }

  private:
    std::vector<Vertex> vertices_;
};

/// The rule of a vertex that is `age` steps older.
VertexKind kind_of(const SharpVertices::Vertex& v, int age) {
    const auto now = [&](double s) { return age == 0 ? s : softened(s); };
    if (now(v.sharpness) > 0) return VertexKind::Corner;
    int sharp = 0;
    for (const auto& spoke : v.spokes) sharp += now(spoke.sharpness) > 0;
    return static_cast<VertexKind>(std::min(sharp, 3));
}

/// How much of a rule that ends with this step is left: the mean of the sharpness that ends.
double share_of_ending(const SharpVertices::Vertex& v) {
    double sum = 0;
    int count = 0;
    const auto add = [&](double s) {
        if (s <= 0 || softened(s) > 0) return;
        sum += s;
        ++count;
    };
    add(v.sharpness);
    for (const auto& spoke : v.spokes) add(spoke.sharpness);
    return count == 0 ? 0 : std::min(sum / count, 1.0);
}

template <class T>
Vec3<T> placed(const SharpVertices::Vertex& v, VertexKind kind, int age, const Vec3<T>* c,
               const Vec3<T>& smooth) {
    if (kind == VertexKind::Corner) return c[v.vertex];
    if (kind != VertexKind::Crease) return smooth;
    Vec3<T> ends;
    for (const auto& spoke : v.spokes)
        if ((age == 0 ? spoke.sharpness : softened(spoke.sharpness)) > 0) ends += c[spoke.target];
    return static_cast<T>(rules::kDyadicMask.self) * c[v.vertex] +
           static_cast<T>(rules::kDyadicMask.point) * ends;
}

/// One array through one step: the smooth rules everywhere, then what is sharp.
template <class T>
class Forward {
  public:
    Forward(const Topology& mesh, const StepRules& rules, const Sharpness& sharpness)
        : mesh_(mesh), step_(mesh, rules), sharpness_(sharpness), vertices_(mesh, sharpness) {}

    [[nodiscard]] std::vector<Vec3<T>> run(const std::vector<Vec3<T>>& c) const {
        std::vector<Vec3<T>> fine(c.size() + step_.new_count());
        step_.apply(c.data(), fine.data(), fine.data() + c.size());
        for (const auto& v : vertices_.all()) {
            const Vec3<T> smooth = fine[v.vertex];
            const VertexKind before = kind_of(v, 0);
            const VertexKind after = kind_of(v, 1);
            Vec3<T> place = placed(v, before, 0, c.data(), smooth);
            if (after != before && before >= VertexKind::Crease) {
                const T part = static_cast<T>(share_of_ending(v));
                place = part * place + (1 - part) * placed(v, after, 1, c.data(), smooth);
            }
            fine[v.vertex] = place;
        }
        if (!sharpness_.edges.empty()) sharpen_edges(c, fine);
        return fine;
    }

  private:
    void sharpen_edges(const std::vector<Vec3<T>>& c, std::vector<Vec3<T>>& fine) const {
        mesh::each_edge(mesh_, [&](Index h, Index next, Index) {
            if (mesh_.on_boundary(h)) return;
            const double s = sharpness_.edges[mesh_.edge[h]];
            if (s <= 0) return;
            const T part = static_cast<T>(std::min(s, 1.0));
            const Vec3<T> middle =
                static_cast<T>(rules::kSharpEdgeEnd) * (c[mesh_.origin[h]] + c[mesh_.origin[next]]);
            Vec3<T>& point = fine[c.size() + mesh_.edge[h]];
            point = part * middle + (1 - part) * point;
        });
    }

    const Topology& mesh_;
    MeshStep<T> step_;
    const Sharpness& sharpness_;
    SharpVertices vertices_;
};

Sharpness refined(const Sharpness& sharpness, const Topology& coarse, const Topology& fine,
                  Split split) {
    Sharpness result;
    if (!sharpness.vertices.empty()) {
        result.vertices.assign(fine.vertex_count, 0);
        std::transform(sharpness.vertices.begin(), sharpness.vertices.end(),
                       result.vertices.begin(), softened);
    }
    if (sharpness.edges.empty()) return result;
    result.edges.assign(fine.edge_count, 0);
    if (split == Split::Sqrt3Odd || split == Split::Sqrt3Even) return result;
    for (Index h = 0; h < coarse.half_edge_count(); ++h)
        for (const Index half : mesh::halves(coarse, split, h))
            result.edges[fine.edge[half]] = softened(sharpness.edges[coarse.edge[h]]);
    return result;
}

}  // namespace

MeshTags tags_of(const Sharpness& sharpness) {
    MeshTags tags;
    const auto sharp = [](double s) { return static_cast<std::uint8_t>(std::isinf(s)); };
    tags.sharp.resize(sharpness.edges.size());
    tags.corner.resize(sharpness.vertices.size());
    std::transform(sharpness.edges.begin(), sharpness.edges.end(), tags.sharp.begin(), sharp);
    std::transform(sharpness.vertices.begin(), sharpness.vertices.end(), tags.corner.begin(),
                   sharp);
    return tags;
}

template <class T>
Result<SubdividedMesh<T>> subdivide(SubdividedMesh<T> mesh, const MeshSpec& spec, int steps) {
    RELIEF_CHECK(check(mesh.mesh, mesh.sharpness, spec.scheme));
    for (const auto& array : mesh.arrays)
        if (array.size() != mesh.mesh.vertex_count)
            return Error{ErrorCode::InvalidArgument,
                         "invalid_parameter: arrays need one element a vertex", "arrays"};
    RELIEF_CHECK(spec.check_steps(mesh.mesh, steps));
    for (int step = 0; step < steps; ++step) {
        const Split split = spec.split(step);
        const MeshTags corners{{}, tags_of(mesh.sharpness).corner};
        RELIEF_TRY(const StepRules rules,
                   step_rules(mesh.mesh, corners, split, {.alpha = spec.alpha}));
        RELIEF_TRY(Topology fine, mesh::refine(mesh.mesh, split));
        const Forward<T> forward(mesh.mesh, rules, mesh.sharpness);
        for (auto& array : mesh.arrays) array = forward.run(array);
        mesh.sharpness = refined(mesh.sharpness, mesh.mesh, fine, split);
        mesh.mesh = std::move(fine);
    }
    return mesh;
}

template Result<SubdividedMesh<float>> subdivide(SubdividedMesh<float>, const MeshSpec&, int);
template Result<SubdividedMesh<double>> subdivide(SubdividedMesh<double>, const MeshSpec&, int);

}  // namespace relief::multires
