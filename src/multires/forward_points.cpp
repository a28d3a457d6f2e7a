#include "multires/forward_points.h"

#include <algorithm>

#include "multires/lanes.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Split;
using mesh::Topology;

Index prev3(Index h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}

/// The regular part of a step: new points in the order of their numbers, and for each old vertex
/// the sum over its ring, which every face has a share of. What sharp edges and boundaries make of
/// it is written over later.
template <class T>
class RegularPoints {
  public:
    using L = Lanes<T>;
    using Vector = typename L::Vector;

    RegularPoints(const Topology& coarse, Vec3<T>* points, T* sums)
        : mesh_(coarse),
          origin_(coarse.origin.data()),
          twin_(coarse.twin.data()),
          points_(points),
          fresh_(points + coarse.vertex_count),
          sums_(sums) {
        std::fill_n(sums, 4 * std::size_t{coarse.vertex_count}, T{0});
    }

    void loop() {
        const Index count = mesh_.half_edge_count();
        for (Index h = 0; h < count; h += 3) {
            L a;
            L b;
            L c;
            load_triangle(h, a, b, c);
            add_ring(h, b);
            add_ring(h + 1, c);
            add_ring(h + 2, a);
            loop_edge(h, a.v + b.v, c);
            loop_edge(h + 1, b.v + c.v, a);
            loop_edge(h + 2, c.v + a.v, b);
        }
    }

    void catmull_clark() {
        Vec3<T>* const faces = fresh_ + mesh_.edge_count;
        if (mesh_.sides == 4) {
            for (Index f = 0; f < mesh_.face_count; ++f) quad_point(f, faces + f);
            for (Index f = 0; f < mesh_.face_count; ++f) quad_edges(f, faces);
            return;
        }
        for (Index f = 0; f < mesh_.face_count; ++f) polygon_point(f, faces + f);
        for (Index f = 0; f < mesh_.face_count; ++f) polygon_edges(f, faces);
    }

    /// Trisected faces have two numbers and no point of their own.
    void sqrt3(const std::vector<Index>& trisected) {
        Index f = 0;
        for (const Index next : trisected) {
            sqrt3_faces(f, next + 1);
            ++fresh_;
            f = next + 1;
        }
        sqrt3_faces(f, mesh_.face_count);
    }

  private:
    void load(Index h, L& point) const { L::load(points_ + origin_[h], point); }
    void load_triangle(Index h, L& a, L& b, L& c) const {
        load(h, a);
        load(h + 1, b);
        load(h + 2, c);
    }

    void add_ring(Index h, const L& point) {
        T* const to = sums_ + 4 * std::size_t{origin_[h]};
        Vector sum;
        std::memcpy(&sum, to, sizeof sum);
        sum += point.v;
        std::memcpy(to, &sum, sizeof sum);
    }

    void loop_edge(Index h, const Vector& ends, const L& wing) {
        const Index twin = twin_[h];
        if (twin <= h) return;
        L other = wing;
        if (twin != kNone) load(prev3(twin), other);
        const L point{static_cast<T>(rules::kLoopEdgeEnd) * ends +
                      static_cast<T>(rules::kLoopEdgeWing) * (wing.v + other.v)};
        point.store(fresh_++);
    }

    void quad_point(Index f, Vec3<T>* to) const {
        L corner[4];
        for (Index k = 0; k < 4; ++k) load(4 * f + k, corner[k]);
        const L point{T{0.25} * ((corner[0].v + corner[1].v) + (corner[2].v + corner[3].v))};
        point.store(to);
    }

    void polygon_point(Index f, Vec3<T>* to) const {
        Vec3<T> sum;
        for (const Index v : mesh_.corners(f)) sum += points_[v];
        *to = T{1} / static_cast<T>(mesh_.size_of(f)) * sum;
    }

    void quad_edges(Index f, const Vec3<T>* faces) {
        L corner[4];
        for (Index k = 0; k < 4; ++k) load(4 * f + k, corner[k]);
        L own;
        L::load_last(faces + f, own);
        for (Index k = 0; k < 4; ++k) {
            const L& next = corner[(k + 1) % 4];
            const Index h = 4 * f + k;
            add_ring(h, {next.v + own.v});
            if (twin_[h] <= h) continue;
            quad_edge(corner[k].v + next.v, own, faces + (twin_[h] == kNone ? f : twin_[h] / 4));
        }
    }

    void polygon_edges(Index f, const Vec3<T>* faces) {
        L own;
        L::load_last(faces + f, own);
        const Index begin = mesh_.first_of(f);
        const Index end = mesh_.first_of(f + 1);
        for (Index h = begin; h < end; ++h) {
            L point;
            L next;
            load(h, point);
            load(h + 1 == end ? begin : h + 1, next);
            add_ring(h, {next.v + own.v});
            const Index twin = twin_[h];
            if (twin <= h) continue;
            quad_edge(point.v + next.v, own, faces + (twin == kNone ? f : mesh_.face_of(twin)));
        }
    }

    void quad_edge(const Vector& ends, const L& own, const Vec3<T>* beyond) {
        L other;
        L::load_last(beyond, other);
        const L point{static_cast<T>(rules::kQuadEdgeEnd) * ends +
                      static_cast<T>(rules::kQuadEdgeFace) * (own.v + other.v)};
        point.store(fresh_++);
    }

    void sqrt3_faces(Index begin, Index end) {
        for (Index f = begin; f < end; ++f) {
            L a;
            L b;
            L c;
            load_triangle(3 * f, a, b, c);
            add_ring(3 * f, b);
            add_ring(3 * f + 1, c);
            add_ring(3 * f + 2, a);
            const L point{static_cast<T>(rules::kFacePoint3) * (a.v + b.v + c.v)};
            point.store(fresh_++);
        }
    }

    const Topology& mesh_;
    const Index* origin_;
    const Index* twin_;
    const Vec3<T>* points_;
    Vec3<T>* fresh_;  ///< the next new point
    T* sums_;
};

template <class T>
void move_old(Index count, const ForwardRules& rules, Vec3<T>* points, const T* sums) {
    const auto move = [&](std::size_t begin, std::size_t end, auto rule_of) {
        for (std::size_t v = begin; v < end; ++v) {
            Lanes<T> point;
            typename Lanes<T>::Vector sum;
            Lanes<T>::load(points + v, point);
            std::memcpy(&sum, sums + 4 * v, sizeof sum);
            const rules::RingRule rule = rule_of(v);
            point.v = static_cast<T>(rule.self) * point.v + static_cast<T>(rule.ring) * sum;
            point.store(points + v);
        }
    };
    const std::size_t first = std::min<std::size_t>(count, rules.first.size());
    move(0, first, [&](std::size_t v) { return rules.first[v]; });
    move(first, count, [rule = rules.others](std::size_t) { return rule; });
}

/// What the terms of all masks sum up to.
template <class T>
std::vector<Vec3<T>> sums_of_masks(const ForwardRules& rules, const Vec3<T>* coarse) {
    std::vector<Vec3<T>> sums(rules.masks.size());
    std::size_t term = 0;
    for (std::size_t k = 0; k < sums.size(); ++k)
        for (; term < rules.masks[k].terms_end; ++term)
            sums[k] += static_cast<T>(rules.terms[term].weight) * coarse[rules.terms[term].coarse];
    return sums;
}

}  // namespace

template <class T>
void forward_points(const Topology& coarse, Split split, const ForwardRules& rules, Vec3<T>* points,
                    T* sums) {
    RegularPoints<T> regular(coarse, points, sums);
    if (split == Split::Loop)
        regular.loop();
    else if (split == Split::CatmullClark)
        regular.catmull_clark();
    else
        regular.sqrt3(rules.trisected);
    const std::vector<Vec3<T>> sharp = sums_of_masks(rules, points);
    move_old(coarse.vertex_count, rules, points, sums);
    for (std::size_t k = 0; k < sharp.size(); ++k) {
        Vec3<T>& point = points[rules.masks[k].fine];
        const auto smooth = static_cast<T>(rules.masks[k].smooth);
        point = smooth == 0 ? sharp[k] : smooth * point + sharp[k];
    }
}

template void forward_points(const Topology&, Split, const ForwardRules&, Vec3<float>*, float*);
template void forward_points(const Topology&, Split, const ForwardRules&, Vec3<double>*, double*);

}  // namespace relief::multires
