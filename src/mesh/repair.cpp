#include "relief/mesh/repair.h"

#include "mesh/loops.h"

namespace relief::mesh {

namespace {

/// Which loops hang together by edges of two, and which of them are turned so that these agree.
struct Orientation {
    std::vector<Index> set;
    std::vector<std::uint8_t> turned;
};

/// Loops that agree are joined first, so that what must be cut is cut where it disagrees already.
TurnedSets joined(const Loops& loops, std::span<const Side> sides) {
    TurnedSets sets(loops.size());
    for (const bool turned : {false, true})
        group_by_edge(sides, [&](std::span<const Side> at) {
            if (at.size() == 2 && same_direction(loops, at[0], at[1]) == turned)
                sets.unite(loops.loop[at[0].corner], loops.loop[at[1].corner], turned);
        });
    return sets;
}

/// The majority of each set keeps its side; if there is none, its first loop does.
Orientation oriented(const Loops& loops, std::span<const Side> sides) {
    TurnedSets sets = joined(loops, sides);
    Orientation result{std::vector<Index>(loops.size()), std::vector<std::uint8_t>(loops.size())};
    std::vector<std::int64_t> balance(loops.size(), 0);  ///< as the root - turned against it
    std::vector<Index> first(loops.size(), kNone);
    for (Index l = 0; l < loops.size(); ++l) {
        const auto [root, turned] = sets.find(l);
        result.set[l] = root;
        result.turned[l] = turned;
        balance[root] += turned ? -1 : 1;
        if (first[root] == kNone) first[root] = l;
    }
    const auto turn_all = [&](Index root) {
        return balance[root] < 0 || (balance[root] == 0 && sets.find(first[root]).turned);
    };
    for (Index l = 0; l < loops.size(); ++l) result.turned[l] ^= turn_all(result.set[l]);
    return result;
}

/// Joins loops along edges where they form a surface; counts the edges where they do not.
class Joiner {
  public:
    Joiner(const Loops& loops, const Orientation& orientation)
        : loops_(loops), orientation_(orientation), fans_(loops.corner.size()) {}

    void join(std::span<const Side> at) {
        if (at.size() < 2) return;
        if (at.size() == 2) {
            if (opposite(at[0], at[1]))
                join_corners(loops_, at[0], at[1], fans_);
            else
                ++edges_cut;
            return;
        }
        ++edges_split;
        sorted_.assign(at.begin(), at.end());
        std::stable_sort(sorted_.begin(), sorted_.end(),
                         [&](const Side& a, const Side& b) { return set(a) < set(b); });
        for (std::size_t begin = 0, end = 0; begin < sorted_.size(); begin = end) {
            while (end < sorted_.size() && set(sorted_[end]) == set(sorted_[begin])) ++end;
            if (end - begin == 2 && opposite(sorted_[begin], sorted_[begin + 1]))
                join_corners(loops_, sorted_[begin], sorted_[begin + 1], fans_);
        }
    }
    [[nodiscard]] Index fan(Index corner) { return fans_.find(corner).root; }

    std::uint64_t edges_cut = 0;
    std::uint64_t edges_split = 0;

  private:
    [[nodiscard]] Index set(const Side& side) const {
        return orientation_.set[loops_.loop[side.corner]];
    }
    /// Whether two loops run along an edge in opposite directions, after those are turned that
    /// must.
    [[nodiscard]] bool opposite(const Side& a, const Side& b) const {
        const bool turned = orientation_.turned[loops_.loop[a.corner]] !=
                            orientation_.turned[loops_.loop[b.corner]];
        return same_direction(loops_, a, b) == turned;
    }

    const Loops& loops_;
    const Orientation& orientation_;
    TurnedSets fans_;           ///< of corners
    std::vector<Side> sorted_;  ///< by sets
};

/// Numbers the fans, the first of each vertex in the order of vertices, then the others. Returns
/// the new vertex of each corner.
std::vector<Index> number_fans(const Loops& loops, Joiner& joiner, Index vertex_count,
                               Repaired& result) {
    const auto corner_count = static_cast<Index>(loops.corner.size());
    std::vector<Index> fan_of(vertex_count, kNone);
    for (Index c = 0; c < corner_count; ++c)
        if (fan_of[loops.vertex(c)] == kNone) fan_of[loops.vertex(c)] = joiner.fan(c);
    std::vector<Index> number(corner_count, kNone);
    const auto add = [&](Index fan, Index vertex) {
        number[fan] = static_cast<Index>(result.vertices.size());
        result.vertices.push_back(vertex);
    };
    for (Index v = 0; v < vertex_count; ++v)
        if (fan_of[v] != kNone) add(fan_of[v], v);
    result.counts.vertices_dropped = vertex_count - result.vertices.size();
    const std::size_t used = result.vertices.size();
    std::vector<Index> vertices(corner_count);
    for (Index c = 0; c < corner_count; ++c) {
        const Index fan = joiner.fan(c);
        if (number[fan] == kNone) add(fan, loops.vertex(c));
        vertices[c] = number[fan];
    }
    result.counts.vertices_added = result.vertices.size() - used;
    result.vertex_count = static_cast<Index>(result.vertices.size());
    return vertices;
}

/// The faces in their new order of corners; turned ones keep the first.
void write_faces(const Loops& loops, std::span<const Index> vertices, Repaired& result) {
    for (Index l = 0; l < loops.size(); ++l) {
        const Index begin = loops.first(l);
        const Index end = loops.first(l + 1);
        for (Index k = begin; k < end; ++k) {
            const Index c = result.turned[l] && k > begin ? end + begin - k : k;
            result.faces.corners.push_back(vertices[c]);
            result.corners.push_back(loops.corner[c]);
        }
        result.faces.offsets.push_back(end);
    }
    result.sources = loops.source;
}

void count_faces(const FaceList& faces, const SortedFaces& sorted, std::span<const Index> equals,
                 RepairCounts& counts) {
    std::uint64_t kept_corners = 0;
    std::uint64_t kept_faces = 0;
    for (Index f = 0; f < faces.size(); ++f) {
        if (sorted.flaws[f].degenerate || sorted.flaws[f].missing != kNone) continue;
        kept_corners += faces[f].size();
        ++kept_faces;
    }
    counts.faces_dropped = faces.size() - kept_faces;
    counts.corners_dropped = kept_corners - sorted.loops.corner.size();
    counts.faces_added = sorted.loops.size() - kept_faces;
    for (Index l = 0; l < equals.size(); ++l) counts.duplicates_dropped += equals[l] != l;
}

}  // namespace

Repaired repair(const FaceList& faces, Index vertex_count) {
    const SortedFaces sorted = sort_faces(faces, vertex_count);
    const std::vector<Index> equals = first_equals(sorted.loops);
    const Loops loops = distinct(sorted.loops, equals);
    const std::vector<Side> sides = sides_of(loops);
    Orientation orientation = oriented(loops, sides);
    Joiner joiner(loops, orientation);
    group_by_edge(sides, [&](std::span<const Side> at) { joiner.join(at); });

    Repaired result;
    const std::vector<Index> vertices = number_fans(loops, joiner, vertex_count, result);
    result.turned = std::move(orientation.turned);
    write_faces(loops, vertices, result);
    count_faces(faces, sorted, equals, result.counts);
    result.counts.faces_turned =
        static_cast<std::uint64_t>(std::count(result.turned.begin(), result.turned.end(), 1));
    result.counts.edges_cut = joiner.edges_cut;
    result.counts.edges_split = joiner.edges_split;
    return result;
}

}  // namespace relief::mesh
