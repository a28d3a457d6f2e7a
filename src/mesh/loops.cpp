#include "mesh/loops.h"

namespace relief::mesh {

namespace {

/// Walks around faces and cuts off a loop whenever it comes back to a vertex.
class LoopCutter {
  public:
    LoopCutter(const FaceList& faces, Index vertex_count, Loops& loops)
        : faces_(faces), loops_(loops), depth_(vertex_count, kNone) {}

    Flaws cut(Index face) {
        Flaws flaws;
        const auto first = static_cast<Index>(faces_.offsets[face]);
        const auto end = static_cast<Index>(faces_.offsets[face + 1]);
        for (Index c = first; c < end; ++c)
            if (faces_.corners[c] >= depth_.size()) flaws.missing = faces_.corners[c];
        if (flaws.missing != kNone) return flaws;
        const Index loops_before = loops_.size();
        for (Index c = first; c < end; ++c) {
            const Index v = faces_.corners[c];
            if (depth_[v] != kNone) {
                flaws.repeated = v;
                emit(face, depth_[v]);
            }
            depth_[v] = static_cast<Index>(open_.size());
            open_.push_back(c);
        }
        emit(face, 0);
        flaws.degenerate = loops_.size() == loops_before;
        return flaws;
    }

  private:
    /// The open corners from a depth on.
    void emit(Index face, std::size_t depth) {
        const bool is_loop = open_.size() >= depth + 3;
        for (std::size_t k = depth; k < open_.size(); ++k) {
            const Index v = faces_.corners[open_[k]];
            depth_[v] = kNone;
            if (!is_loop) continue;
            loops_.faces.corners.push_back(v);
            loops_.corner.push_back(open_[k]);
            loops_.loop.push_back(loops_.size());
        }
        open_.resize(depth);
        if (!is_loop) return;
        loops_.faces.offsets.push_back(static_cast<std::int64_t>(loops_.corner.size()));
        loops_.source.push_back(face);
    }

    const FaceList& faces_;
    Loops& loops_;
    std::vector<Index> depth_;  ///< of a vertex among the open corners
    std::vector<Index> open_;   ///< different vertices that are not in a loop yet
};

/// The corners from the smallest vertex on, in the direction of its smaller neighbour.
FaceList canonical(const Loops& loops) {
    FaceList result = loops.faces;
    for (Index l = 0; l < loops.size(); ++l) {
        const auto begin = result.corners.begin() + loops.faces.offsets[l];
        const auto end = result.corners.begin() + loops.faces.offsets[l + 1];
        std::rotate(begin, std::min_element(begin, end), end);
        if (*(begin + 1) > *(end - 1)) std::reverse(begin + 1, end);
    }
    return result;
}

}  // namespace

SortedFaces sort_faces(const FaceList& faces, Index vertex_count) {
    SortedFaces result;
    result.flaws.reserve(faces.size());
    LoopCutter cutter(faces, vertex_count, result.loops);
    for (Index f = 0; f < faces.size(); ++f) result.flaws.push_back(cutter.cut(f));
    return result;
}

std::vector<Index> first_equals(const Loops& loops) {
    const FaceList faces = canonical(loops);
    const auto less = [&](Index a, Index b) {
        const auto p = faces[a];
        const auto q = faces[b];
        return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    };
    std::vector<Index> order(loops.size());
    std::iota(order.begin(), order.end(), Index{0});
    std::stable_sort(order.begin(), order.end(), less);
    std::vector<Index> first(loops.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        first[order[k]] = k > 0 && !less(order[k - 1], order[k]) ? first[order[k - 1]] : order[k];
    return first;
}

Loops distinct(const Loops& loops, std::span<const Index> equals) {
    Loops result;
    for (Index l = 0; l < loops.size(); ++l) {
        if (equals[l] != l) continue;
        result.faces.add(loops.faces[l]);
        for (Index c = loops.first(l); c < loops.first(l + 1); ++c) {
            result.corner.push_back(loops.corner[c]);
            result.loop.push_back(result.size());
        }
        result.source.push_back(loops.source[l]);
    }
    return result;
}

std::vector<Side> sides_of(const Loops& loops) {
    std::vector<Side> sides(loops.corner.size());
    for (Index c = 0; c < sides.size(); ++c) {
        const Index a = loops.vertex(c);
        const Index b = loops.vertex(loops.next(c));
        sides[c] = {std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), c};
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return a.edge != b.edge ? a.edge < b.edge : a.corner < b.corner;
    });
    return sides;
}

}  // namespace relief::mesh
