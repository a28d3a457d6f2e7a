#include "multires/mesh_normal.h"

#include <algorithm>
#include <utility>

#include "multires/mesh_points.h"
#include "relief/core/parallel.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Split;

/// Vertices or faces of a block: enough to pay for a thread.
constexpr std::int64_t kBlock = 1 << 13;

template <class Visit>
void each_block(std::size_t count, Visit visit) {
    parallel_for(0, static_cast<std::int64_t>(count), kBlock,
                 [&](std::int64_t begin, std::int64_t end) {
                     visit(static_cast<Index>(begin), static_cast<Index>(end));
                 });
}

/// The first half-edges of face f and of the next one.
template <Index Sides>
std::pair<Index, Index> sides_of(const mesh::Topology& mesh, Index f) {
    if constexpr (Sides == 0)
        return {mesh.first_of(f), mesh.first_of(f + 1)};
    else
        return {Sides * f, Sides * f + Sides};
}

template <Index Sides>
Index face_of(const mesh::Topology& mesh, Index h) {
    if constexpr (Sides == 0)
        return mesh.face_of(h);
    else
        return h / Sides;
}

}  // namespace

MeshNormal::MeshNormal(const MeshStep<double>& step) : mesh_(step.coarse()), rules_(step.rules()) {
    count_vertices();
    list_rings();
    list_rows();
    if (rules_.split == Split::CatmullClark) {
        list_regular();
        list_rest();
        mend_darts();
        return;
    }
    if (rules_.split == Split::Loop) {
        constexpr double end = rules::kLoopEdgeEnd;
        constexpr double wing = rules::kLoopEdgeWing;
        near_ = end * end + 4 * end * wing;
        far_ = wing * wing;
        mend_triangles();
        mend_darts();
        return;
    }
    constexpr double corner = rules::kFacePoint3;
    near_ = 2 * corner * corner;
    for (const ApexWeight& w : rules_.apexes)
        terms_.push_back({place_[w.apex], place_[w.apex], -corner * corner});
}

void MeshNormal::count_vertices() {
    const Index count = mesh_.vertex_count;
    Index inner = 0;
    for (Index v = 0; v < count; ++v) inner += rules_.kinds[v] <= VertexKind::Dart;
    vertices_ = Buffer<Index>(inner);
    place_ = Buffer<Index>(count);
    for (Index v = 0; v < count; ++v)
        place_[v] = rules_.kinds[v] <= VertexKind::Dart ? kNone : inner;
    Index next = 0;
    for (Index h = 0; h < mesh_.half_edge_count(); ++h) {
        const Index v = mesh_.origin[h];
        if (place_[v] != kNone) continue;
        vertices_[next] = v;
        place_[v] = next++;
    }
}

void MeshNormal::list_rings() {
    const auto inner = static_cast<Index>(size());
    first_ = Buffer<Index>(std::size_t{inner} + 1);
    std::fill_n(first_.data(), first_.size(), Index{0});
    for (Index h = 0; h < mesh_.half_edge_count(); ++h) ++first_[place_[mesh_.origin[h]]];
    Index sum = 0;
    for (Index v = 0; v < inner; ++v) sum += std::exchange(first_[v], sum);
    first_[inner] = sum;
    ring_ = Buffer<Index>(sum);
    const bool loop = rules_.split == Split::Loop;
    const bool quads = rules_.split == Split::CatmullClark;
    if (loop || quads) across_ = Buffer<Index>(sum);
    if (quads) diagonal_ = Buffer<Index>(sum);
    Buffer<Index> end(inner);
    std::copy_n(first_.data(), inner, end.data());
    mesh::each_half_edge(mesh_, [&](Index f, Index h, Index next, Index) {
        const Index v = place_[mesh_.origin[h]];
        if (v == inner) return;
        const Index k = end[v]++;
        ring_[k] = place_[mesh_.origin[next]];
        if (loop) {
            const bool open = is_sharp(rules_, mesh_, next);
            across_[k] = open ? inner : place_[mesh_.origin[mesh_.prev(mesh_.twin[next])]];
        } else if (quads) {
            across_[k] = f;
            diagonal_[k] = mesh_.size_of(f) == 4 ? place_[mesh_.target(next)] : inner;
        }
    });
}

void MeshNormal::list_rows() {
    for (Index v = 0; v < size(); ++v) {
        const Index n = first_[v + 1] - first_[v];
        if (n >= rows_.size()) rows_.resize(std::size_t{n} + 1);
        Row& row = rows_[n];
        if (row.own > 0) continue;
        if (rules_.split == Split::Loop) {
            constexpr double end = rules::kLoopEdgeEnd;
            constexpr double wing = rules::kLoopEdgeWing;
            const rules::RingRule rule = rules::loop_ring(n);
            row = {rule.self, rule.ring, n * (end * end + wing * wing)};
        } else if (rules_.split == Split::CatmullClark) {
            const rules::RingRule rule = rules::catmull_clark_ring(n);
            row = {rule.self, rule.ring, n * rules::kQuadEdgeEnd * rules::kQuadEdgeEnd};
        } else {
            const double ring = rules_.point[vertices_[v]] * 2 / 3;  // K = 3 alpha / (2 n)
            row = {1 - n * ring, ring, n * rules::kFacePoint3 * rules::kFacePoint3};
        }
    }
}

void MeshNormal::list_regular() {
    regular_ = Buffer<Place>(size());
    for (Index v = 0; v < size(); ++v) {
        bool regular = rules_.kinds[vertices_[v]] == VertexKind::Smooth;
        regular = regular && first_[v + 1] - first_[v] == 4;
        for (Index k = first_[v]; regular && k < first_[v + 1]; ++k)
            regular = mesh_.size_of(across_[k]) == 4;
        regular_[v] = regular ? Place::Regular : Place::Irregular;
    }
    const auto is_regular = [&](Index v) { return v < size() && regular_[v] != Place::Irregular; };
    for (Index v = 0; v < size(); ++v) {
        bool deep = is_regular(v);
        for (Index k = first_[v]; deep && k < first_[v + 1]; ++k)
            deep = is_regular(ring_[k]) && is_regular(diagonal_[k]);
        if (deep) regular_[v] = Place::Deep;
    }
}

/// What the vertices look at that are not deep.
void MeshNormal::list_rest() {
    std::vector<bool> faces(mesh_.face_count);
    std::vector<bool> shares(mesh_.face_count);
    std::vector<bool> rings(size() + 1);
    const auto mark_faces = [&](Index v, std::vector<bool>& marks) {
        for (Index k = first_[v]; k < first_[v + 1]; ++k) marks[across_[k]] = true;
    };
    const auto list = [](const std::vector<bool>& marks, std::size_t count,
                         std::vector<Index>& out) {
        for (std::size_t k = 0; k < count; ++k)
            if (marks[k]) out.push_back(static_cast<Index>(k));
    };
    for (Index v = 0; v < size(); ++v)
        if (regular_[v] != Place::Deep) mark_faces(v, shares);
    list(shares, shares.size(), rest_shares_);
    for (const Index f : rest_shares_)
        for (Index h = mesh_.first_of(f); h < mesh_.first_of(f + 1); ++h) {
            faces[f] = true;
            rings[place_[mesh_.origin[h]]] = true;
            if (!mesh_.on_boundary(h)) faces[mesh_.face_of(mesh_.twin[h])] = true;
        }
    list(rings, size(), rest_rings_);
    for (const Index v : rest_rings_) mark_faces(v, faces);
    list(faces, faces.size(), rest_faces_);
}

/// Loop: sharp edges give nothing to the vertices opposite.
void MeshNormal::mend_triangles() {
    constexpr double wing = rules::kLoopEdgeWing;
    mesh::each_half_edge(mesh_, [&](Index, Index h, Index, Index prev) {
        const Index v = place_[mesh_.origin[prev]];
        if (v < size() && is_sharp(rules_, mesh_, h)) terms_.push_back({v, v, -wing * wing});
    });
}

/// weight (sum of vertices)^2, as a quadratic form.
void MeshNormal::add_square(std::initializer_list<Index> vertices, double weight) {
    for (const Index v : vertices)
        for (const Index w : vertices)
            if (v < size() && w < size()) terms_.push_back({v, w, weight});
}

void MeshNormal::mend_darts() {
    if (rules_.sharp.empty()) return;
    constexpr double sharp = rules::kSharpEdgeEnd * rules::kSharpEdgeEnd;
    constexpr double end = rules::kLoopEdgeEnd;
    constexpr double cross = end * rules::kLoopEdgeWing;
    mesh::each_edge(mesh_, [&](Index h, Index next, Index prev) {
        const Index a = place_[mesh_.origin[h]];
        const Index b = place_[mesh_.origin[next]];
        if ((a == size() && b == size()) || !is_sharp(rules_, mesh_, h)) return;
        for (const Index v : {h, next})
            if (rules_.kinds[mesh_.origin[v]] == VertexKind::Crease)
                creases_.push_back({mesh_.origin[v], v == h ? b : a});
        const Index twin = mesh_.twin[h];
        if (rules_.split == Split::CatmullClark) {
            dart_edges_.push_back({{a, b}, {mesh_.face_of(h), mesh_.face_of(twin)}});
            return;
        }
        add_square({a, b}, sharp - end * end);
        for (const Index v : {a, b})
            for (const Index corner : {prev, mesh_.prev(twin)}) {
                const Index w = place_[mesh_.origin[corner]];
                if (v == size() || w == size()) continue;
                terms_.push_back({v, w, -cross});
                terms_.push_back({w, v, -cross});
            }
    });
    // The rows of crease vertices.
    constexpr double along = rules::kDyadicMask.point * rules::kDyadicMask.point;
    std::sort(creases_.begin(), creases_.end());
    for (std::size_t k = 0; k < creases_.size(); ++k)
        if (k + 1 < creases_.size() && creases_[k][0] == creases_[k + 1][0]) {
            add_square({creases_[k][1], creases_[k + 1][1]}, along);
            ++k;
        } else {
            add_square({creases_[k][1]}, along);
        }
}

MeshNormal::Passes::Passes(const MeshNormal& normal)
    : image(normal.size()), spread(normal.size() + 1) {
    spread[normal.size()] = {};
    if (normal.rules_.split != Split::CatmullClark) return;
    faces = Points(normal.mesh_.face_count);
    shares = Points(normal.mesh_.face_count);
    smoothed = Points(normal.size());
}

/// Triangles: all but what comes back from the ring.
void MeshNormal::through_rings(const Vec3<double>* x, Passes& passes) const {
    each_block(size(), [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const Row& row = row_of(v);
            Vec3<double> near;
            for (Index k = first_[v]; k < first_[v + 1]; ++k) near += x[ring_[k]];
            const Vec3<double> g = row.self * x[v] + row.ring * near;
            Vec3<double> image = row.self * g + row.own * x[v] + near_ * near;
            if (far_ > 0) {
                Vec3<double> far;
                for (Index k = first_[v]; k < first_[v + 1]; ++k) far += x[across_[k]];
                image += far_ * far;
            }
            passes.image[v] = image;
            passes.spread[v] = row.ring * g;
        }
    });
    for (const Term& term : terms_) passes.image[term.row] += term.weight * x[term.column];
}

/// Catmull-Clark: P^T P of cubic curves is (1 28 70 28 1) / 64, in s = z + 1/z
/// (s^2 + 28 s + 68) / 64 = (s + kFirst) (s + kSecond) / 64.
constexpr double kEightRoot2 = 11.313708498984761;
constexpr double kFirst = 14 - kEightRoot2;
constexpr double kSecond = 14 + kEightRoot2;

/// (s + shift) (t + shift) x for both directions of the quads around a vertex.
[[gnu::always_inline]] inline Vec3<double> shifted_product(const Vec3<double>* x, Index v,
                                                           const Index* ring, const Index* diagonal,
                                                           double shift) {
    const Vec3<double> near = (x[ring[0]] + x[ring[1]]) + (x[ring[2]] + x[ring[3]]);
    const Vec3<double> far = (x[diagonal[0]] + x[diagonal[1]]) + (x[diagonal[2]] + x[diagonal[3]]);
    return shift * shift * x[v] + shift * near + far;
}

void MeshNormal::sum_regular(const Vec3<double>* x, Passes& passes) const {
    each_block(size(), [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v)
            if (regular_[v] != Place::Irregular)
                passes.smoothed[v] = shifted_product(x, v, ring_.data() + first_[v],
                                                     diagonal_.data() + first_[v], kFirst);
    });
}

/// Catmull-Clark: the points of faces.
template <Index Sides>
void MeshNormal::to_faces(const Vec3<double>* x, Passes& passes) const {
    each_block(rest_faces_.size(), [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            const Index f = rest_faces_[k];
            const auto [first, last] = sides_of<Sides>(mesh_, f);
            Vec3<double> sum;
            for (Index h = first; h < last; ++h) sum += x[place_[mesh_.origin[h]]];
            passes.faces[f] = 1.0 / (last - first) * sum;
        }
    });
}

/// What vertices give to the ring: through old vertices, and through edges.
void MeshNormal::through_quad_rings(const Vec3<double>* x, Passes& passes) const {
    constexpr double edge = rules::kQuadEdgeEnd * rules::kQuadEdgeEnd;
    each_block(rest_rings_.size(), [&](Index begin, Index end) {
        for (Index n = begin; n < end; ++n) {
            const Index v = rest_rings_[n];
            const Row& row = row_of(v);
            Vec3<double> sum;
            for (Index k = first_[v]; k < first_[v + 1]; ++k)
                sum += x[ring_[k]] + passes.faces[across_[k]];
            const Vec3<double> g = row.self * x[v] + row.ring * sum;
            passes.image[v] = row.self * g + row.own * x[v];
            passes.spread[v] = row.ring * g + edge * x[v];
        }
    });
    for (const Term& term : terms_) passes.image[term.row] += term.weight * x[term.column];
}

/// What faces give to their corners: as a part of old vertices, of edges, and by their own points.
template <Index Sides>
void MeshNormal::from_faces(const Vec3<double>* x, Passes& passes) const {
    constexpr double edge = rules::kQuadEdgeEnd * rules::kQuadEdgeEnd;
    each_block(rest_shares_.size(), [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
            const Index f = rest_shares_[k];
            const auto [first, last] = sides_of<Sides>(mesh_, f);
            Vec3<double> sum;
            Vec3<double> beside;
            Index smooth = 0;
            for (Index h = first; h < last; ++h) {
                sum += passes.spread[place_[mesh_.origin[h]]];
                if (is_sharp(rules_, mesh_, h)) continue;
                beside += passes.faces[face_of<Sides>(mesh_, mesh_.twin[h])];
                ++smooth;
            }
            const Vec3<double>& point = passes.faces[f];
            const Index sides = last - first;
            passes.shares[f] =
                1.0 / sides * (sum + (edge * (sides + smooth) + 1) * point + edge * beside) +
                2 * edge * point;
        }
    });
    constexpr double sharp = rules::kSharpEdgeEnd * rules::kSharpEdgeEnd;
    for (const DartEdge& dart : dart_edges_) {
        const Vec3<double> ends = x[dart.ends[0]] + x[dart.ends[1]];
        const Vec3<double> points = passes.faces[dart.faces[0]] + passes.faces[dart.faces[1]];
        for (const Index v : dart.ends)
            if (v < size()) passes.image[v] += (sharp - edge) * ends - edge * points;
        for (const Index f : dart.faces) passes.shares[f] -= edge / mesh_.size_of(f) * ends;
    }
}

/// What comes back from the ring.
Vec3<double> MeshNormal::from_ring(Index v, const Passes& passes) const {
    Vec3<double> sum = passes.image[v];
    if (rules_.split == Split::CatmullClark)
        for (Index k = first_[v]; k < first_[v + 1]; ++k)
            sum += passes.spread[ring_[k]] + passes.shares[across_[k]];
    else
        for (Index k = first_[v]; k < first_[v + 1]; ++k) sum += passes.spread[ring_[k]];
    return sum;
}

/// finish(v, (P^T P x)_v) for all vertices; it may alter x[v].
template <class Finish>
void MeshNormal::images(const Vec3<double>* x, Passes& passes, Finish finish) const {
    if (rules_.split != Split::CatmullClark) {
        through_rings(x, passes);
        each_block(size(), [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) finish(v, from_ring(v, passes));
        });
        return;
    }
    sum_regular(x, passes);
    const bool quads = mesh_.sides == 4;
    quads ? to_faces<4>(x, passes) : to_faces<0>(x, passes);
    through_quad_rings(x, passes);
    quads ? from_faces<4>(x, passes) : from_faces<0>(x, passes);
    each_block(size(), [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v)
            if (regular_[v] == Place::Deep)
                finish(v, 1.0 / 4096 *
                              shifted_product(passes.smoothed.data(), v, ring_.data() + first_[v],
                                              diagonal_.data() + first_[v], kSecond));
            else
                finish(v, from_ring(v, passes));
    });
}

/// image += P_new^T fresh; Catmull-Clark: `shares` gets what faces give to their corners.
template <class Fresh>
void MeshNormal::from_fresh(Fresh fresh, Passes& passes) const {
    Points& image = passes.image;
    const auto add = [&](Index h, const Vec3<double>& value) {
        const Index v = place_[mesh_.origin[h]];
        if (v < size()) image[v] += value;
    };
    if (rules_.split == Split::Loop) {
        mesh::each_half_edge(mesh_, [&](Index, Index h, Index, Index prev) {
            const bool sharp = is_sharp(rules_, mesh_, h);
            const Vec3<double> value = fresh(mesh_.edge[h]);
            add(h, (sharp ? rules::kSharpEdgeEnd : rules::kLoopEdgeEnd) * value);
            if (!sharp) add(prev, rules::kLoopEdgeWing * value);
        });
        return;
    }
    if (rules_.split != Split::CatmullClark) {
        for (Index f = 0; f < mesh_.face_count; ++f) {
            if (is_trisected(mesh_, rules_, f)) continue;
            const Vec3<double> share = rules::kFacePoint3 * fresh(face_point(mesh_, rules_, f));
            for (Index h = 3 * f; h < 3 * f + 3; ++h) add(h, share);
        }
        return;
    }
    for (Index f = 0; f < mesh_.face_count; ++f) {
        Vec3<double> sum = fresh(mesh_.edge_count + f);
        for (Index h = mesh_.first_of(f); h < mesh_.first_of(f + 1); ++h) {
            sum += passes.spread[place_[mesh_.origin[h]]];
            const bool sharp = is_sharp(rules_, mesh_, h);
            const Vec3<double> value = fresh(mesh_.edge[h]);
            add(h, (sharp ? rules::kSharpEdgeEnd : rules::kQuadEdgeEnd) * value);
            if (!sharp) sum += rules::kQuadEdgeFace * value;
        }
        passes.shares[f] = 1.0 / mesh_.size_of(f) * sum;
    }
}

template <class Old, class Fresh>
MeshNormal::Points MeshNormal::adjoint_of(Old old, Fresh fresh, Passes& passes) const {
    for (Index v = 0; v < size(); ++v) {
        const Vec3<double> value = old(vertices_[v]);
        passes.image[v] = row_of(v).self * value;
        passes.spread[v] = row_of(v).ring * value;
    }
    from_fresh(fresh, passes);
    for (const auto& [crease, dart] : creases_)
        passes.image[dart] += rules::kDyadicMask.point * old(crease);
    Points result(size());
    each_block(size(), [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) result[v] = from_ring(v, passes);
    });
    return result;
}

MeshNormal::Points MeshNormal::adjoint(const Vec3<double>* old, const Vec3<double>* fresh,
                                       Passes& passes) const {
    return adjoint_of([&](Index v) { return old[v]; }, [&](Index x) { return fresh[x]; }, passes);
}

MeshNormal::Points MeshNormal::column_sums() const {
    const auto one = [](Index) { return Vec3<double>{1, 1, 1}; };
    Passes passes(*this);
    return adjoint_of(one, one, passes);
}

void MeshNormal::apply(const Vec3<double>* x, Vec3<double>* y, Passes& passes) const {
    Points padded(size() + 1);
    std::copy_n(x, size(), padded.data());
    padded[size()] = {};
    images(padded.data(), passes, [&](Index v, const Vec3<double>& image) { y[v] = image; });
}

MeshNormal::Points MeshNormal::sweep(const LiftOptions& options, const std::vector<double>& scale,
                                     const Points& target, Passes& passes) const {
    const double centre = (1 + options.lowest) / 2;
    const double radius = (1 - options.lowest) / 2;
    const double sigma = centre / radius;
    double rho = 1 / sigma;
    Points x(size() + 1);
    Points move(size());
    for (Index v = 0; v < size(); ++v) x[v] = move[v] = scale[v] / centre * target[v];
    x[size()] = {};
    for (int sweep = 1; sweep < options.sweeps; ++sweep) {
        const double next = 1 / (2 * sigma - rho);
        const double keep = next * rho;
        const double size = 2 * next / radius;
        images(x.data(), passes, [&](Index v, const Vec3<double>& image) {
            move[v] = keep * move[v] + size * scale[v] * (target[v] - image);
            x[v] += move[v];
        });
        rho = next;
    }
    return x;
}

}  // namespace relief::multires
