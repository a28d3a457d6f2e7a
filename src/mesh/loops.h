#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "relief/mesh/topology.h"

/// Polygons that need not be a manifold, sorted out for diagnosis and repair.
namespace relief::mesh {

/// What is wrong with a face by itself.
struct Flaws {
    Index missing = kNone;   ///< a vertex that it names and that does not exist
    Index repeated = kNone;  ///< a vertex that it names twice
    bool degenerate = false;
};

/// Polygons of three and more different corners, and which faces they were made of.
struct Loops {
    FaceList faces;
    std::vector<Index> source;  ///< of each loop: its face
    std::vector<Index> corner;  ///< of each corner: its place among the corners of all faces
    std::vector<Index> loop;    ///< of each corner: the loop

    [[nodiscard]] Index size() const { return static_cast<Index>(source.size()); }
    [[nodiscard]] Index vertex(Index c) const { return faces.corners[c]; }
    [[nodiscard]] Index first(Index l) const { return static_cast<Index>(faces.offsets[l]); }
    /// The next corner of the same loop.
    [[nodiscard]] Index next(Index c) const {
        return c + 1 == first(loop[c] + 1) ? first(loop[c]) : c + 1;
    }
};

/// The loops of all faces, in their order, and what is wrong with each face.
struct SortedFaces {
    Loops loops;
    std::vector<Flaws> flaws;
};
[[nodiscard]] SortedFaces sort_faces(const FaceList& faces, Index vertex_count);

/// For each loop the first one with the same corners in either direction; itself if it is that.
[[nodiscard]] std::vector<Index> first_equals(const Loops& loops);

/// Those loops that are their own first equals.
[[nodiscard]] Loops distinct(const Loops& loops, std::span<const Index> equals);

/// A side of a loop: from corner c to the next.
struct Side {
    std::uint64_t edge = 0;  ///< 2^32 x the smaller end + the larger
    Index corner = 0;

    [[nodiscard]] Index low() const { return static_cast<Index>(edge >> 32); }
    [[nodiscard]] Index high() const { return static_cast<Index>(edge); }
};

/// All sides, those of the same edge beside each other, by ascending corners.
[[nodiscard]] std::vector<Side> sides_of(const Loops& loops);

/// visit(the sides of one edge) for all edges, by ascending ends.
template <class Visit>
void group_by_edge(std::span<const Side> sides, Visit&& visit) {
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        while (end < sides.size() && sides[end].edge == sides[begin].edge) ++end;
        visit(sides.subspan(begin, end - begin));
    }
}

/// Whether two sides of an edge begin at the same vertex.
[[nodiscard]] inline bool same_direction(const Loops& loops, const Side& a, const Side& b) {
    return loops.vertex(a.corner) == loops.vertex(b.corner);
}

/// Disjoint sets of elements, each of which lies like the root of its set or turned.
class TurnedSets {
  public:
    struct Place {
        Index root = 0;
        bool turned = false;
    };

    explicit TurnedSets(std::size_t count) : parent_(count), size_(count, 1), turned_(count, 0) {
        std::iota(parent_.begin(), parent_.end(), Index{0});
    }

    [[nodiscard]] Place find(Index element) {
        bool turned = false;
        while (parent_[element] != element) {
            const Index up = parent_[element];
            turned_[element] ^= turned_[up];
            parent_[element] = parent_[up];
            turned ^= turned_[element] != 0;
            element = parent_[element];
        }
        return {element, turned};
    }

    /// Joins the sets of two elements, if these are different, such that b lies like a or turned.
    void unite(Index a, Index b, bool turned) {
        Place p = find(a);
        Place q = find(b);
        if (p.root == q.root) return;
        if (size_[p.root] < size_[q.root]) std::swap(p, q);
        parent_[q.root] = p.root;
        size_[p.root] += size_[q.root];
        turned_[q.root] = p.turned ^ q.turned ^ turned;
    }

  private:
    std::vector<Index> parent_;
    std::vector<Index> size_;
    std::vector<std::uint8_t> turned_;  ///< against the parent; 0 for roots
};

/// Joins the corners of two loops at both ends of an edge that they share.
inline void join_corners(const Loops& loops, const Side& a, const Side& b, TurnedSets& fans) {
    const bool same = same_direction(loops, a, b);
    fans.unite(a.corner, same ? b.corner : loops.next(b.corner), false);
    fans.unite(loops.next(a.corner), same ? loops.next(b.corner) : b.corner, false);
}

}  // namespace relief::mesh
