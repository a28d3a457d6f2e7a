#include "relief/multires/mesh_step.h"

#include <algorithm>

#include "multires/mesh_points.h"
#include "multires/stiff_system.h"
#include "relief/mesh/walk.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Split;
using mesh::Topology;

template <class T>
constexpr T weight(double w) {
    return static_cast<T>(w);
}

/// Triangles: the half-edge before.
Index prev3(Index h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}

/// The means of the corners of faces, and back.
template <class T>
Vec3<T> face_mean(const Topology& mesh, const Vec3<T>* c, Index f) {
    Vec3<T> sum;
    for (const Index v : mesh.corners(f)) sum += c[v];
    return T{1} / static_cast<T>(mesh.size_of(f)) * sum;
}

template <class T>
void face_means_adjoint(const Topology& mesh, const Vec3<T>* faces, Vec3<T>* c) {
    for (Index f = 0; f < mesh.face_count; ++f) {
        const Vec3<T> share = T{1} / static_cast<T>(mesh.size_of(f)) * faces[f];
        for (const Index v : mesh.corners(f)) c[v] += share;
    }
}

// predict: put(x, P_new c at x) for all new vertices.
template <class T>
struct LoopPoints {
    template <class Put>
    static void predict(const Topology& mesh, const StepRules& rules, const Vec3<T>* c, Put put) {
        mesh::each_edge(mesh, [&](Index h, Index next, Index prev) {
            const Vec3<T> ends = c[mesh.origin[h]] + c[mesh.origin[next]];
            if (is_sharp(rules, mesh, h)) {
                put(mesh.edge[h], weight<T>(rules::kSharpEdgeEnd) * ends);
                return;
            }
            const Vec3<T> wings = c[mesh.origin[prev]] + c[mesh.origin[prev3(mesh.twin[h])]];
            put(mesh.edge[h],
                weight<T>(rules::kLoopEdgeEnd) * ends + weight<T>(rules::kLoopEdgeWing) * wings);
        });
    }

    static void adjoint(const Topology& mesh, const StepRules& rules, const Vec3<T>* y,
                        Vec3<T>* c) {
        mesh::each_edge(mesh, [&](Index h, Index next, Index prev) {
            const Vec3<T>& value = y[mesh.edge[h]];
            const bool sharp = is_sharp(rules, mesh, h);
            const Vec3<T> end =
                weight<T>(sharp ? rules::kSharpEdgeEnd : rules::kLoopEdgeEnd) * value;
            c[mesh.origin[h]] += end;
            c[mesh.origin[next]] += end;
            if (sharp) return;
            const Vec3<T> wing = weight<T>(rules::kLoopEdgeWing) * value;
            c[mesh.origin[prev]] += wing;
            c[mesh.origin[prev3(mesh.twin[h])]] += wing;
        });
    }
};

template <class T>
struct QuadPoints {
    template <class Put>
    static void predict(const Topology& mesh, const StepRules& rules, const Vec3<T>* c, Put put) {
        Buffer<Vec3<T>> means(mesh.face_count);
        for (Index f = 0; f < mesh.face_count; ++f) {
            means[f] = face_mean(mesh, c, f);
            put(mesh.edge_count + f, means[f]);
        }
        mesh::each_half_edge(mesh, [&](Index f, Index h, Index next, Index) {
            if (!mesh.is_first(h)) return;
            const Vec3<T> ends = c[mesh.origin[h]] + c[mesh.origin[next]];
            if (is_sharp(rules, mesh, h)) {
                put(mesh.edge[h], weight<T>(rules::kSharpEdgeEnd) * ends);
                return;
            }
            const Vec3<T> both = means[f] + means[mesh.face_of(mesh.twin[h])];
            put(mesh.edge[h],
                weight<T>(rules::kQuadEdgeEnd) * ends + weight<T>(rules::kQuadEdgeFace) * both);
        });
    }

    static void adjoint(const Topology& mesh, const StepRules& rules, Vec3<T>* y, Vec3<T>* c) {
        Vec3<T>* faces = y + mesh.edge_count;
        mesh::each_half_edge(mesh, [&](Index f, Index h, Index next, Index) {
            if (!mesh.is_first(h)) return;
            const Vec3<T>& value = y[mesh.edge[h]];
            const bool sharp = is_sharp(rules, mesh, h);
            const Vec3<T> end =
                weight<T>(sharp ? rules::kSharpEdgeEnd : rules::kQuadEdgeEnd) * value;
            c[mesh.origin[h]] += end;
            c[mesh.origin[next]] += end;
            if (sharp) return;
            const Vec3<T> part = weight<T>(rules::kQuadEdgeFace) * value;
            faces[f] += part;
            faces[mesh.face_of(mesh.twin[h])] += part;
        });
        face_means_adjoint(mesh, faces, c);
    }
};

template <class T>
struct Sqrt3Points {
    template <class Put>
    static void predict(const Topology& mesh, const StepRules& rules, const Vec3<T>* c, Put put) {
        for (Index f = 0; f < mesh.face_count; ++f) {
            if (is_trisected(mesh, rules, f)) continue;
            const Index* v = mesh.origin.data() + 3 * f;
            put(face_point(mesh, rules, f),
                weight<T>(rules::kFacePoint3) * (c[v[0]] + c[v[1]] + c[v[2]]));
        }
        for (const Trisection& third : rules.trisections) {
            put(third.point,
                near_point(c[third.from], c[third.to], c[third.before], third.from_corner));
            put(third.point + 1,
                near_point(c[third.to], c[third.from], c[third.after], third.to_corner));
        }
    }

    static Vec3<T> near_point(const Vec3<T>& near, const Vec3<T>& far, const Vec3<T>& beyond,
                              bool corner) {
        if (corner)
            return weight<T>(rules::kThirdOfCorner) * near +
                   weight<T>(rules::kThirdOfCornerFar) * far;
        return weight<T>(rules::kThirdNear) * near + weight<T>(rules::kThirdFar) * far +
               weight<T>(rules::kThirdBeyond) * beyond;
    }

    static void adjoint(const Topology& mesh, const StepRules& rules, const Vec3<T>* y,
                        Vec3<T>* c) {
        for (Index f = 0; f < mesh.face_count; ++f) {
            if (is_trisected(mesh, rules, f)) continue;
            const Vec3<T> share = weight<T>(rules::kFacePoint3) * y[face_point(mesh, rules, f)];
            for (Index h = 3 * f; h < 3 * f + 3; ++h) c[mesh.origin[h]] += share;
        }
        for (const Trisection& third : rules.trisections) {
            near_adjoint(y[third.point], c[third.from], c[third.to], c[third.before],
                         third.from_corner);
            near_adjoint(y[third.point + 1], c[third.to], c[third.from], c[third.after],
                         third.to_corner);
        }
    }

    static void near_adjoint(const Vec3<T>& y, Vec3<T>& near, Vec3<T>& far, Vec3<T>& beyond,
                             bool corner) {
        near += weight<T>(corner ? rules::kThirdOfCorner : rules::kThirdNear) * y;
        far += weight<T>(corner ? rules::kThirdOfCornerFar : rules::kThirdFar) * y;
        if (!corner) beyond += weight<T>(rules::kThirdBeyond) * y;
    }
};

template <class T, class Put>
void predict_each(const Topology& mesh, const StepRules& rules, const Vec3<T>* c, Put put) {
    if (rules.split == Split::Loop) return LoopPoints<T>::predict(mesh, rules, c, put);
    if (rules.split == Split::CatmullClark) return QuadPoints<T>::predict(mesh, rules, c, put);
    Sqrt3Points<T>::predict(mesh, rules, c, put);
}

}  // namespace

template <class T>
void MeshStep<T>::predict(ConstPoints c, Points fresh) const {
    predict_each(mesh_, rules_, c, [&](Index x, const Vec3<T>& value) { fresh[x] = value; });
}

template <class T>
void MeshStep<T>::predict_adjoint(Points y, Points c) const {
    if (rules_.split == Split::Loop) return LoopPoints<T>::adjoint(mesh_, rules_, y, c);
    if (rules_.split == Split::CatmullClark) return QuadPoints<T>::adjoint(mesh_, rules_, y, c);
    Sqrt3Points<T>::adjoint(mesh_, rules_, y, c);
}

template <class T>
void MeshStep<T>::gather(ConstPoints fresh, Points old) const {
    std::fill_n(old, coarse_count(), Vec3<T>());
    each_point_around<T>(mesh_, rules_, [&](Index v, Index point, T sign) {
        old[v] += sign == 1 ? fresh[point] : sign * fresh[point];
    });
    for (Index v = 0; v < mesh_.vertex_count; ++v) old[v] = weight<T>(rules_.point[v]) * old[v];
    for (const PointWeight& w : rules_.points)
        old[w.vertex] += weight<T>(w.weight) * fresh[w.point];
}

template <class T>
void MeshStep<T>::gather_adjoint(ConstPoints old, Points fresh) const {
    each_point_around<T>(mesh_, rules_, [&](Index v, Index point, T sign) {
        fresh[point] += sign * weight<T>(rules_.point[v]) * old[v];
    });
    for (const PointWeight& w : rules_.points)
        fresh[w.point] += weight<T>(w.weight) * old[w.vertex];
}

template <class T>
void MeshStep<T>::add_self(ConstPoints c, Points old) const {
    for (Index v = 0; v < mesh_.vertex_count; ++v) old[v] += weight<T>(rules_.self[v]) * c[v];
    for (const ApexWeight& w : rules_.apexes)
        old[w.apex] += weight<T>(w.weight) * (c[w.from] + c[w.to]);
}

template <class T>
void MeshStep<T>::self_adjoint(ConstPoints old, Points c) const {
    for (Index v = 0; v < mesh_.vertex_count; ++v) c[v] = weight<T>(rules_.self[v]) * old[v];
    for (const ApexWeight& w : rules_.apexes) {
        const Vec3<T> part = weight<T>(w.weight) * old[w.apex];
        c[w.from] += part;
        c[w.to] += part;
    }
}

template <class T>
void MeshStep<T>::apply(ConstPoints c, Points old, Points fresh) const {
    predict(c, fresh);
    gather(fresh, old);
    add_self(c, old);
}

template <class T>
void MeshStep<T>::adjoint(ConstPoints old, Points fresh, Points c) const {
    gather_adjoint(old, fresh);
    self_adjoint(old, c);
    predict_adjoint(fresh, c);
}

template <class T>
void MeshStep<T>::analyse(Points fine, Points residuals, Points scratch) const {
    const Points fresh = fine + coarse_count();
    gather(fresh, scratch);
    const StiffVertices& stiff = rules_.stiff;
    for (std::size_t k = 0; k < stiff.size(); ++k)
        residuals[k] = fine[stiff.vertices[k]] - scratch[stiff.vertices[k]];
    // Curves first: apexes of trisected triangles need them.
    for (Index v = 0; v < mesh_.vertex_count; ++v)
        if (rules_.self[v] != 0)
            scratch[v] = T{1} / weight<T>(rules_.self[v]) * (fine[v] - scratch[v]);
    for (const ApexWeight& w : rules_.apexes)
        scratch[w.apex] -=
            weight<T>(w.weight / rules_.self[w.apex]) * (scratch[w.from] + scratch[w.to]);
    if (stiff.size() > 0) solve_stiff(fine, scratch, scratch);
    std::copy_n(scratch, coarse_count(), fine);
    const ConstPoints c = fine;
    predict_each(mesh_, rules_, c, [&](Index x, const Vec3<T>& value) { fresh[x] -= value; });
}

template <class T>
void MeshStep<T>::synthesise(Points fine, ConstPoints residuals, Points scratch) const {
    const Points fresh = fine + coarse_count();
    const ConstPoints c = fine;
    predict_each(mesh_, rules_, c, [&](Index x, const Vec3<T>& value) { fresh[x] += value; });
    gather(fresh, scratch);
    add_self(fine, scratch);
    for (std::size_t k = 0; k < rules_.stiff.size(); ++k)
        scratch[rules_.stiff.vertices[k]] += residuals[k];
    std::copy_n(scratch, coarse_count(), fine);
}

/// gathered: K fresh at stiff vertices, c at others. The sum of the edge sums at v, of which n^2 K
/// fresh is the sum and that of the faces' points, less the neighbours that are known.
template <class T>
void MeshStep<T>::solve_stiff(ConstPoints fine, ConstPoints gathered, Points c) const {
    const StiffVertices& stiff = rules_.stiff;
    std::vector<Index> place(mesh_.vertex_count, kNone);
    for (std::size_t k = 0; k < stiff.size(); ++k) place[stiff.vertices[k]] = static_cast<Index>(k);
    std::vector<Vec3<T>> known(stiff.size());
    for (std::size_t k = 0; k < stiff.size(); ++k) known[k] = T{9} * gathered[stiff.vertices[k]];
    const Vec3<T>* faces = fine + coarse_count() + mesh_.edge_count;
    mesh::each_half_edge(mesh_, [&](Index f, Index h, Index next, Index) {
        const Index k = place[mesh_.origin[h]];
        if (k != kNone) known[k] -= faces[f];
        const Index other = place[mesh_.origin[next]];
        if (k != kNone && other == kNone) known[k] -= gathered[mesh_.origin[next]];
    });
    std::vector<Vec3<T>> solution = solve_stiff_system<T>(stiff, known);
    for (const auto& component : stiff.alternating) {
        Vec3<T> mean;
        for (std::size_t k = 0; k < component.places.size(); ++k)
            mean += static_cast<T>(component.signs[k]) * fine[stiff.vertices[component.places[k]]];
        mean = T{1} / static_cast<T>(component.places.size()) * mean;
        for (std::size_t k = 0; k < component.places.size(); ++k)
            solution[component.places[k]] += static_cast<T>(component.signs[k]) * mean;
    }
    for (std::size_t k = 0; k < stiff.size(); ++k) c[stiff.vertices[k]] = solution[k];
}

template class MeshStep<float>;
template class MeshStep<double>;

}  // namespace relief::multires
