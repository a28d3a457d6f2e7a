#include "multires/mesh_normal.h"

#include <algorithm>

#include "multires/mesh_points.h"
#include "relief/core/parallel.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::Split;

/// Vertices or faces of a block: enough to pay for a thread.
constexpr std::int64_t kBlock = 1 << 13;

template <class Visit>
void each_block(Index count, Visit visit) {
    parallel_for(0, count, kBlock, [&](std::int64_t begin, std::int64_t end) {
        visit(static_cast<Index>(begin), static_cast<Index>(end));
    });
}

}  // namespace

MeshNormal::MeshNormal(const MeshStep<double>& step) : mesh_(step.coarse()), rules_(step.rules()) {
    list_rings(step);
    list_rows(step);
    if (rules_.split == Split::CatmullClark) {
        mend_darts(step);
        return;
    }
    if (rules_.split == Split::Loop) {
        constexpr double end = rules::kLoopEdgeEnd;
        constexpr double wing = rules::kLoopEdgeWing;
        near_ = end * end + 4 * end * wing;
        far_ = wing * wing;
        mend_triangles(step);
        mend_darts(step);
        return;
    }
    constexpr double corner = rules::kFacePoint3;
    near_ = 2 * corner * corner;
    for (const ApexWeight& w : rules_.apexes) terms_.push_back({w.apex, w.apex, -corner * corner});
}

void MeshNormal::list_rings(const MeshStep<double>& step) {
    const Index count = mesh_.vertex_count;
    const auto is_free = [&](Index v) { return rules_.kinds[v] <= VertexKind::Dart; };
    first_ = Buffer<Index>(std::size_t{count} + 1);
    std::fill_n(first_.data(), first_.size(), Index{0});
    for (Index h = 0; h < mesh_.half_edge_count(); ++h)
        if (is_free(mesh_.origin[h])) ++first_[mesh_.origin[h] + 1];
    for (Index v = 0; v < count; ++v) first_[v + 1] += first_[v];
    ring_ = Buffer<Index>(first_[count]);
    const bool loop = rules_.split == Split::Loop;
    if (loop || rules_.split == Split::CatmullClark) across_ = Buffer<Index>(first_[count]);
    Buffer<Index> end(count);
    std::copy_n(first_.data(), count, end.data());
    mesh::each_half_edge(mesh_, [&](Index f, Index h, Index next, Index) {
        const Index v = mesh_.origin[h];
        if (!is_free(v)) return;
        const Index place = end[v]++;
        ring_[place] = mesh_.origin[next];
        if (loop) {
            // Nothing is across a sharp edge: its ends are zero there, or mended.
            const bool open = is_sharp(step.rules(), mesh_, next);
            across_[place] = mesh_.origin[open ? next : mesh_.prev(mesh_.twin[next])];
        } else if (across_.size() > 0) {
            across_[place] = f;
        }
    });
}

void MeshNormal::list_rows(const MeshStep<double>& step) {
    for (Index v = 0; v < mesh_.vertex_count; ++v) {
        const Index n = first_[v + 1] - first_[v];
        if (n >= rows_.size()) rows_.resize(std::size_t{n} + 1);
        Row& row = rows_[n];
        if (n == 0 || row.own > 0) continue;
        if (rules_.split == Split::Loop) {
            constexpr double end = rules::kLoopEdgeEnd;
            constexpr double wing = rules::kLoopEdgeWing;
            const double alpha = rules::loop_alpha(n);
            row = {1 - n * alpha, alpha, n * (end * end + wing * wing)};
        } else if (rules_.split == Split::CatmullClark) {
            const double share = 1.0 / (static_cast<double>(n) * n);
            row = {(n - 2.0) / n, share, n * rules::kQuadEdgeEnd * rules::kQuadEdgeEnd};
        } else {
            // K = 3 alpha / (2 n)
            const double ring = step.rules().point[v] * 2 / 3;
            row = {1 - n * ring, ring, n * rules::kFacePoint3 * rules::kFacePoint3};
        }
    }
}

/// Loop: sharp edges give nothing to the vertices opposite.
void MeshNormal::mend_triangles(const MeshStep<double>& step) {
    constexpr double wing = rules::kLoopEdgeWing;
    mesh::each_half_edge(mesh_, [&](Index, Index h, Index, Index prev) {
        const Index v = mesh_.origin[prev];
        if (!is_inner(v) || !is_sharp(step.rules(), mesh_, h)) return;
        terms_.push_back({v, v, -wing * wing});
        // What stands in the list in place of the vertex across.
        if (is_inner(mesh_.origin[h])) terms_.push_back({v, mesh_.origin[h], -wing * wing});
    });
}

/// weight (sum of vertices)^2, as a quadratic form.
void MeshNormal::add_square(std::initializer_list<Index> vertices, double weight) {
    for (const Index v : vertices)
        for (const Index w : vertices) terms_.push_back({v, w, weight});
}

void MeshNormal::mend_darts(const MeshStep<double>& step) {
    if (rules_.sharp.empty()) return;
    constexpr double sharp = rules::kSharpEdgeEnd * rules::kSharpEdgeEnd;
    constexpr double cross = rules::kLoopEdgeEnd * rules::kLoopEdgeWing;
    std::vector<std::array<Index, 2>> beside;  // crease vertices, and darts beside them
    mesh::each_edge(mesh_, [&](Index h, Index next, Index prev) {
        const Index a = mesh_.origin[h];
        const Index b = mesh_.origin[next];
        if ((!is_inner(a) && !is_inner(b)) || !is_sharp(step.rules(), mesh_, h)) return;
        if (rules_.kinds[a] == VertexKind::Crease) beside.push_back({a, b});
        if (rules_.kinds[b] == VertexKind::Crease) beside.push_back({b, a});
        const Index twin = mesh_.twin[h];
        if (rules_.split == Split::CatmullClark) {
            dart_edges_.push_back({{a, b}, {mesh_.face_of(h), mesh_.face_of(twin)}});
            return;
        }
        add_square({a, b}, sharp - rules::kLoopEdgeEnd * rules::kLoopEdgeEnd);
        for (const Index v : {a, b})
            for (const Index w : {mesh_.origin[prev], mesh_.origin[mesh_.prev(twin)]}) {
                terms_.push_back({v, w, -cross});
                terms_.push_back({w, v, -cross});
            }
    });
    // The rows of crease vertices.
    constexpr double along = rules::kDyadicMask.point * rules::kDyadicMask.point;
    std::sort(beside.begin(), beside.end());
    for (std::size_t k = 0; k < beside.size(); ++k) {
        const bool both = k + 1 < beside.size() && beside[k][0] == beside[k + 1][0];
        if (both)
            add_square({beside[k][1], beside[k + 1][1]}, along);
        else
            add_square({beside[k][1]}, along);
        if (both) ++k;
    }
}

MeshNormal::Scratch MeshNormal::scratch() const {
    Scratch scratch;
    scratch.image = Points(mesh_.vertex_count);
    scratch.spread = Points(mesh_.vertex_count);
    if (rules_.split != Split::CatmullClark) return scratch;
    scratch.faces = Points(mesh_.face_count);
    scratch.shares = Points(mesh_.face_count);
    return scratch;
}

/// Triangles: all but what comes back from the ring.
void MeshNormal::to_rings(const Vec3<double>* x, Scratch& scratch) const {
    each_block(mesh_.vertex_count, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const Row& row = rows_[first_[v + 1] - first_[v]];
            Vec3<double> near;
            for (Index k = first_[v]; k < first_[v + 1]; ++k) near += x[ring_[k]];
            const Vec3<double> g = row.self * x[v] + row.ring * near;
            Vec3<double> image = row.self * g + row.own * x[v] + near_ * near;
            if (far_ > 0) {
                Vec3<double> far;
                for (Index k = first_[v]; k < first_[v + 1]; ++k) far += x[across_[k]];
                image += far_ * far;
            }
            scratch.image[v] = image;
            scratch.spread[v] = row.ring * g;
        }
    });
    for (const Term& term : terms_) scratch.image[term.row] += term.weight * x[term.column];
}

/// Catmull-Clark: the points of faces.
void MeshNormal::to_faces(const Vec3<double>* x, Scratch& scratch) const {
    each_block(mesh_.face_count, [&](Index begin, Index end) {
        for (Index f = begin; f < end; ++f) {
            Vec3<double> sum;
            for (const Index v : mesh_.corners(f)) sum += x[v];
            scratch.faces[f] = 1.0 / mesh_.size_of(f) * sum;
        }
    });
}

/// What vertices give to the ring: through old vertices, and through edges.
void MeshNormal::to_quad_rings(const Vec3<double>* x, Scratch& scratch) const {
    constexpr double edge = rules::kQuadEdgeEnd * rules::kQuadEdgeEnd;
    each_block(mesh_.vertex_count, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            const Row& row = rows_[first_[v + 1] - first_[v]];
            Vec3<double> sum;
            for (Index k = first_[v]; k < first_[v + 1]; ++k)
                sum += x[ring_[k]] + scratch.faces[across_[k]];
            const Vec3<double> g = row.self * x[v] + row.ring * sum;
            scratch.image[v] = row.self * g + row.own * x[v];
            scratch.spread[v] = row.ring * g + edge * x[v];
        }
    });
    for (const Term& term : terms_) scratch.image[term.row] += term.weight * x[term.column];
}

/// What faces give to their corners: as a part of old vertices, of edges, and by their own points.
void MeshNormal::from_faces(const Vec3<double>* x, Scratch& scratch) const {
    constexpr double edge = rules::kQuadEdgeEnd * rules::kQuadEdgeEnd;
    each_block(mesh_.face_count, [&](Index begin, Index end) {
        for (Index f = begin; f < end; ++f) {
            const Index size = mesh_.size_of(f);
            Vec3<double> corners;
            Vec3<double> beside;
            Index smooth = 0;
            for (Index h = mesh_.first_of(f); h < mesh_.first_of(f + 1); ++h) {
                corners += scratch.spread[mesh_.origin[h]];
                if (is_sharp(rules_, mesh_, h)) continue;
                beside += scratch.faces[mesh_.face_of(mesh_.twin[h])];
                ++smooth;
            }
            const Vec3<double>& point = scratch.faces[f];
            scratch.shares[f] =
                1.0 / size * (corners + (edge * (size + smooth) + 1) * point + edge * beside) +
                2 * edge * point;
        }
    });
    for (const DartEdge& dart : dart_edges_) {
        const Vec3<double> ends = x[dart.ends[0]] + x[dart.ends[1]];
        const Vec3<double> points = scratch.faces[dart.faces[0]] + scratch.faces[dart.faces[1]];
        constexpr double sharp = rules::kSharpEdgeEnd * rules::kSharpEdgeEnd;
        for (const Index v : dart.ends) scratch.image[v] += (sharp - edge) * ends - edge * points;
        for (const Index f : dart.faces) scratch.shares[f] -= edge / mesh_.size_of(f) * ends;
    }
}

/// finish(v, (P^T P x)_v) for all vertices; it may alter x[v].
template <class Finish>
void MeshNormal::images(const Vec3<double>* x, Scratch& scratch, Finish finish) const {
    const bool quads = rules_.split == Split::CatmullClark;
    if (quads) {
        to_faces(x, scratch);
        to_quad_rings(x, scratch);
        from_faces(x, scratch);
    } else {
        to_rings(x, scratch);
    }
    each_block(mesh_.vertex_count, [&](Index begin, Index end) {
        for (Index v = begin; v < end; ++v) {
            if (!is_inner(v)) {
                finish(v, Vec3<double>());
                continue;
            }
            Vec3<double> image = scratch.image[v];
            for (Index k = first_[v]; k < first_[v + 1]; ++k) image += scratch.spread[ring_[k]];
            for (Index k = first_[v]; quads && k < first_[v + 1]; ++k)
                image += scratch.shares[across_[k]];
            finish(v, image);
        }
    });
}

void MeshNormal::apply(const Vec3<double>* x, Vec3<double>* y) const {
    Scratch passes = scratch();
    images(x, passes, [&](Index v, const Vec3<double>& image) { y[v] = image; });
}

void MeshNormal::sweep(const LiftOptions& options, const double* scale, const Vec3<double>* target,
                       Vec3<double>* out) const {
    const double centre = (1 + options.lowest) / 2;
    const double radius = (1 - options.lowest) / 2;
    const double sigma = centre / radius;
    double rho = 1 / sigma;
    Scratch passes = scratch();
    const Index count = mesh_.vertex_count;
    Points x(count);
    Points move(count);
    for (Index v = 0; v < count; ++v)
        x[v] = move[v] = is_inner(v) ? scale[v] / centre * target[v] : Vec3<double>();
    for (int sweep = 1; sweep < options.sweeps; ++sweep) {
        const double next = 1 / (2 * sigma - rho);
        const double keep = next * rho;
        const double size = 2 * next / radius;
        images(x.data(), passes, [&](Index v, const Vec3<double>& image) {
            if (!is_inner(v)) return;
            move[v] = keep * move[v] + size * scale[v] * (target[v] - image);
            x[v] += move[v];
        });
        rho = next;
    }
    for (Index v = 0; v < count; ++v)
        if (is_inner(v)) out[v] = x[v];
}

}  // namespace relief::multires
