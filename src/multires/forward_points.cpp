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
            const Lanes<T> a = load(h);
            const Lanes<T> b = load(h + 1);
            const Lanes<T> c = load(h + 2);
            loop_edge(h, a, b, c);
            loop_edge(h + 1, b, c, a);
            loop_edge(h + 2, c, a, b);
        }
    }

    void catmull_clark() {
        Vec3<T>* const faces = fresh_ + mesh_.edge_count;
        if (mesh_.sides == 4) {
            for (Index f = 0; f < mesh_.face_count; ++f) quad_point(4 * f, faces + f);
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
    [[nodiscard]] Lanes<T> load(Index h) const { return Lanes<T>::load(points_ + origin_[h]); }

    void add_ring(Index h, const Lanes<T>& point) {
        T* const to = sums_ + 4 * std::size_t{origin_[h]};
        (Lanes<T>::load(to) + point).store(to);
    }

    /// From a to b, in front of c.
    void loop_edge(Index h, const Lanes<T>& a, const Lanes<T>& b, const Lanes<T>& c) {
        add_ring(h, b);
        const Index twin = twin_[h];
        if (twin <= h) return;
        const Lanes<T> other = twin == kNone ? c : load(prev3(twin));
        const Lanes<T> point = static_cast<T>(rules::kLoopEdgeEnd) * (a + b) +
                               static_cast<T>(rules::kLoopEdgeWing) * (c + other);
        point.store(fresh_++);
    }

    void quad_point(Index h, Vec3<T>* to) const {
        const Lanes<T> sum = (load(h) + load(h + 1)) + (load(h + 2) + load(h + 3));
        (T{0.25} * sum).store(to);
    }

    void polygon_point(Index f, Vec3<T>* to) const {
        Vec3<T> sum;
        for (const Index v : mesh_.corners(f)) sum += points_[v];
        *to = T{1} / static_cast<T>(mesh_.size_of(f)) * sum;
    }

    void quad_edges(Index f, const Vec3<T>* faces) {
        const Lanes<T> own = Lanes<T>::load_last(faces + f);
        const Index h = 4 * f;
        const Lanes<T> a = load(h);
        const Lanes<T> b = load(h + 1);
        const Lanes<T> c = load(h + 2);
        const Lanes<T> d = load(h + 3);
        const auto edge = [&](Index side, const Lanes<T>& from, const Lanes<T>& to) {
            add_ring(side, to + own);
            const Index twin = twin_[side];
            if (twin <= side) return;
            add_edge(from + to, own, faces + (twin == kNone ? f : twin / 4));
        };
        edge(h, a, b);
        edge(h + 1, b, c);
        edge(h + 2, c, d);
        edge(h + 3, d, a);
    }

    void polygon_edges(Index f, const Vec3<T>* faces) {
        const Lanes<T> own = Lanes<T>::load_last(faces + f);
        const Index begin = mesh_.first_of(f);
        const Index end = mesh_.first_of(f + 1);
        for (Index h = begin; h < end; ++h) {
            const Lanes<T> to = load(h + 1 == end ? begin : h + 1);
            add_ring(h, to + own);
            const Index twin = twin_[h];
            if (twin <= h) continue;
            add_edge(load(h) + to, own, faces + (twin == kNone ? f : mesh_.face_of(twin)));
        }
    }

    void add_edge(const Lanes<T>& ends, const Lanes<T>& own, const Vec3<T>* beyond) {
        const Lanes<T> both = own + Lanes<T>::load_last(beyond);
        const Lanes<T> point = static_cast<T>(rules::kQuadEdgeEnd) * ends +
                               static_cast<T>(rules::kQuadEdgeFace) * both;
        point.store(fresh_++);
    }

    void sqrt3_faces(Index begin, Index end) {
        for (Index h = 3 * begin; h < 3 * end; h += 3) {
            const Lanes<T> a = load(h);
            const Lanes<T> b = load(h + 1);
            const Lanes<T> c = load(h + 2);
            add_ring(h, b);
            add_ring(h + 1, c);
            add_ring(h + 2, a);
            (static_cast<T>(rules::kFacePoint3) * (a + b + c)).store(fresh_++);
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
            const rules::RingRule rule = rule_of(v);
            const Lanes<T> point = static_cast<T>(rule.self) * Lanes<T>::load(points + v) +
                                   static_cast<T>(rule.ring) * Lanes<T>::load(sums + 4 * v);
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
