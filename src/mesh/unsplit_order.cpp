#include <algorithm>

#include "mesh/twins.h"
#include "relief/mesh/near_order.h"
#include "relief/mesh/recognise.h"

/// Meshes whose numbers are those of `refine`: what was split stands in them, to be read off.
namespace relief::mesh {

namespace {

/// Sets a twin if the edges of both half-edges have the same ends.
bool link(Topology& coarse, Index h, Index twin) {
    if (twin != kNone &&
        (twin >= coarse.half_edge_count() || coarse.origin[twin] != coarse.target(h) ||
         coarse.origin[h] != coarse.target(twin)))
        return false;
    coarse.twin[h] = twin;
    return true;
}

/// Boundary edges are halved by Loop and Catmull-Clark.
Index coarse_edges(const Topology& fine, Index half_edges) {
    const Index boundary = 2 * fine.edge_count - fine.half_edge_count();
    return (half_edges + boundary / 2) / 2;
}

/// Fine faces 4f .. 4f + 3: (v0, e0, e2), (v1, e1, e0), (v2, e2, e1), (e0, e1, e2).
bool read_loop(const Topology& fine, Topology& coarse) {
    coarse.face_count = fine.face_count / 4;
    coarse.sides = 3;
    coarse.origin = Buffer<Index>(3 * std::size_t{coarse.face_count});
    coarse.twin = Buffer<Index>(coarse.origin.size());
    const Index edges = coarse_edges(fine, coarse.half_edge_count());
    if (fine.face_count % 4 != 0 || edges >= fine.vertex_count) return false;
    coarse.vertex_count = fine.vertex_count - edges;
    for (Index f = 0; f < coarse.face_count; ++f) {
        const Index* corners = fine.origin.data() + 12 * f;
        for (Index k = 0; k < 3; ++k) {
            coarse.origin[3 * f + k] = corners[3 * k];
            if (corners[3 * k] >= coarse.vertex_count || corners[3 * k + 1] != corners[9 + k] ||
                corners[3 * k + 2] != corners[9 + (k + 2) % 3])
                return false;
        }
    }
    for (Index f = 0; f < coarse.face_count; ++f)
        for (Index k = 0; k < 3; ++k) {
            // Half of the edge, from its origin; the twin is the last side of a corner's face.
            const Index half = fine.twin[12 * f + 3 * k];
            const bool ends = half % 3 == 2 && half % 12 < 9;
            if (half != kNone && !ends) return false;
            const Index twin = half == kNone ? kNone : 3 * (half / 12) + (half % 12 / 3 + 2) % 3;
            if (!link(coarse, 3 * f + k, twin)) return false;
        }
    number_edges(coarse);
    for (Index h = 0; h < coarse.half_edge_count(); ++h)
        if (fine.origin[12 * (h / 3) + 9 + h % 3] != coarse.vertex_count + coarse.edge[h])
            return false;
    return coarse.edge_count == edges;
}

/// The points of faces, each in so many quads that follow each other as the face has sides.
bool read_polygons(const Topology& fine, Topology& coarse) {
    const Index quads = fine.face_count;
    std::vector<Index> first;
    bool all3 = true;
    bool all4 = true;
    const auto point = [&](Index h) { return fine.origin[4 * h + 2]; };
    for (Index h = 0; h < quads;) {
        Index end = h + 1;
        while (end < quads && point(end) == point(h)) ++end;
        if (end - h < 3) return false;
        all3 = all3 && end - h == 3;
        all4 = all4 && end - h == 4;
        first.push_back(h);
        h = end;
    }
    coarse.face_count = static_cast<Index>(first.size());
    coarse.sides = all4 ? 4 : all3 ? 3 : 0;
    if (coarse.sides != 0) return true;
    first.push_back(quads);
    coarse.first = Buffer<Index>(first.size());
    std::copy(first.begin(), first.end(), coarse.first.data());
    coarse.face = Buffer<Index>(quads);
    for (Index f = 0; f < coarse.face_count; ++f)
        std::fill(coarse.face.data() + first[f], coarse.face.data() + first[f + 1], f);
    return true;
}

/// Fine face h: (origin of h, point of its edge, of its face, of the edge before).
bool read_catmull_clark(const Topology& fine, Topology& coarse) {
    if (!read_polygons(fine, coarse)) return false;
    coarse.origin = Buffer<Index>(fine.face_count);
    coarse.twin = Buffer<Index>(fine.face_count);
    const Index edges = coarse_edges(fine, coarse.half_edge_count());
    if (std::uint64_t{edges} + coarse.face_count >= fine.vertex_count) return false;
    coarse.vertex_count = fine.vertex_count - edges - coarse.face_count;
    const Index points = coarse.vertex_count + edges;
    for (Index h = 0; h < coarse.half_edge_count(); ++h) {
        coarse.origin[h] = fine.origin[4 * h];
        if (coarse.origin[h] >= coarse.vertex_count ||
            fine.origin[4 * h + 2] != points + coarse.face_of(h))
            return false;
    }
    for (Index h = 0; h < coarse.half_edge_count(); ++h) {
        const Index half = fine.twin[4 * h];
        if (half != kNone && half % 4 != 3) return false;
        if (!link(coarse, h, half == kNone ? kNone : coarse.prev(half / 4))) return false;
    }
    number_edges(coarse);
    for (Index h = 0; h < coarse.half_edge_count(); ++h)
        if (fine.origin[4 * h + 1] != coarse.vertex_count + coarse.edge[h] ||
            fine.origin[4 * h + 3] != coarse.vertex_count + coarse.edge[coarse.prev(h)])
            return false;
    return coarse.edge_count == edges;
}

/// sqrt(3), but for trisected boundaries: fine faces (a, R, L), (b, L, R) of edges from a to b with
/// the points of the faces on both sides, (a, b, L) on the boundary.
class Sqrt3Reader {
  public:
    Sqrt3Reader(const Topology& fine, Topology& coarse) : fine_(fine), coarse_(coarse) {
        coarse.face_count = fine.face_count / 3;
        coarse.sides = 3;
    }

    bool run() {
        if (fine_.face_count % 3 != 0 || coarse_.face_count >= fine_.vertex_count) return false;
        coarse_.vertex_count = fine_.vertex_count - coarse_.face_count;
        const std::size_t half_edges = 3 * std::size_t{coarse_.face_count};
        sides_ = Buffer<Side>(half_edges);
        fill_ = std::vector<std::uint8_t>(coarse_.face_count, 0);
        coarse_.origin = Buffer<Index>(half_edges);
        coarse_.twin = Buffer<Index>(half_edges);
        return read_edges() && arrange() && numbers_agree();
    }

  private:
    /// A side of a coarse face, as its edge has it.
    struct Side {
        Index origin = 0;
        Index target = 0;
        Index edge = 0;
        Index other = 0;  ///< the face on the other side
    };

    [[nodiscard]] bool is_old(Index v) const { return v < coarse_.vertex_count; }

    bool add(Index point, const Side& side) {
        const Index f = point - coarse_.vertex_count;
        if (fill_[f] == 3) return false;
        sides_[3 * f + fill_[f]++] = side;
        return true;
    }

    bool read_edges() {
        Index edge = 0;
        for (Index f = 0; f < fine_.face_count; ++edge) {
            const Index* face = fine_.origin.data() + 3 * f;
            const Index a = face[0];
            const Index left = face[2];
            if (!is_old(a) || is_old(left)) return false;
            if (is_old(face[1])) {
                if (!add(left, {a, face[1], edge, kNone})) return false;
                ++f;
                continue;
            }
            const Index right = face[1];
            if (f + 1 == fine_.face_count) return false;
            const Index b = face[3];
            if (!is_old(b) || b <= a || face[4] != left || face[5] != right) return false;
            const Index first = coarse_.vertex_count;
            if (!add(left, {a, b, edge, right - first}) || !add(right, {b, a, edge, left - first}))
                return false;
            f += 2;
        }
        coarse_.edge_count = edge;
        return true;
    }

    /// Where faces begin shows in the order of the edges that none before them has. Where it does
    /// not, they begin with the smallest vertex, as those do that a step has made.
    bool arrange() {
        for (Index f = 0; f < coarse_.face_count; ++f) {
            if (fill_[f] != 3) return false;
            Side* sides = sides_.data() + 3 * f;
            if (sides[1].origin != sides[0].target) std::swap(sides[1], sides[2]);
            for (Index k = 0; k < 3; ++k)
                if (sides[k].target != sides[(k + 1) % 3].origin) return false;
            const auto begin_with_least = [&](auto key) {
                std::rotate(sides, std::min_element(sides, sides + 3, key), sides + 3);
            };
            begin_with_least([](const Side& a, const Side& b) { return a.origin < b.origin; });
            if (!new_edges_ascend(sides, f))
                begin_with_least([f](const Side& a, const Side& b) {
                    return std::pair(a.other <= f, a.edge) < std::pair(b.other <= f, b.edge);
                });
            for (Index k = 0; k < 3; ++k) coarse_.origin[3 * f + k] = sides[k].origin;
        }
        return true;
    }

    [[nodiscard]] static bool new_edges_ascend(const Side* sides, Index f) {
        Index last = 0;
        for (Index k = 0; k < 3; ++k) {
            if (sides[k].other <= f) continue;
            if (sides[k].edge < last) return false;
            last = sides[k].edge;
        }
        return true;
    }

    bool numbers_agree() {
        for (Index h = 0; h < coarse_.half_edge_count(); ++h) {
            const Side& side = sides_[h];
            coarse_.twin[h] = kNone;
            for (Index k = 0; side.other != kNone && k < 3; ++k)
                if (sides_[3 * side.other + k].edge == side.edge && 3 * side.other + k != h)
                    coarse_.twin[h] = 3 * side.other + k;
        }
        const Index edges = coarse_.edge_count;
        number_edges(coarse_);
        for (Index h = 0; h < coarse_.half_edge_count(); ++h)
            if (coarse_.edge[h] != sides_[h].edge) return false;
        return coarse_.edge_count == edges;
    }

    const Topology& fine_;
    Topology& coarse_;
    Buffer<Side> sides_;
    std::vector<std::uint8_t> fill_;  ///< sides of each face so far
};

}  // namespace

std::optional<Topology> unsplit_in_order(const Topology& fine, Split split) {
    Topology coarse;
    bool found = false;
    if (split == Split::CatmullClark)
        found = fine.sides == 4 && read_catmull_clark(fine, coarse);
    else if (split == Split::Loop)
        found = fine.sides == 3 && read_loop(fine, coarse);
    else if (split == Split::Sqrt3Odd || 2 * fine.edge_count == fine.half_edge_count())
        found = fine.sides == 3 && Sqrt3Reader(fine, coarse).run();
    if (!found) return std::nullopt;
    return coarse;
}

bool is_built(const Topology& mesh) {
    const auto built = build(faces_of(mesh), mesh.vertex_count);
    return built.ok() &&
           std::equal(mesh.twin.data(), mesh.twin.data() + mesh.twin.size(), built->twin.data());
}

}  // namespace relief::mesh
