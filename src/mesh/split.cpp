#include "relief/mesh/split.h"

#include <algorithm>
#include <string>

#include "relief/mesh/walk.h"

namespace relief::mesh {

namespace {

constexpr std::uint64_t kMostElements = (std::uint64_t{1} << 31) - 1;

Index next3(Index h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}
Index prev3(Index h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}

/// The half-edges of a finer mesh are written in order; so edges get their numbers as they come.
class EdgeNumbers {
  public:
    explicit EdgeNumbers(Topology& fine) : twin_(fine.twin.data()), edge_(fine.edge.data()) {}

    /// The next half-edges, whose twins are known, up to `end`.
    void continue_to(Index end) {
        for (; next_ < end; ++next_) {
            const bool is_first = next_ < twin_[next_];
            // Half-edge 0 has a number by now, if it is read.
            const Index known = edge_[is_first ? 0 : twin_[next_]];
            edge_[next_] = is_first ? count_ : known;
            count_ += is_first;
        }
    }

  private:
    const Index* twin_;
    Index* edge_;
    Index next_ = 0;
    Index count_ = 0;
};

/// Triangle f has the children 4f .. 4f + 3: their corners.
void set_children(const Topology& coarse, Index f, Index* corners) {
    const Index* origin = coarse.origin.data() + 3 * f;
    const Index* edge = coarse.edge.data() + 3 * f;
    const Index first_new = coarse.vertex_count;
    const std::array<Index, 3> points{first_new + edge[0], first_new + edge[1],
                                      first_new + edge[2]};
    for (std::size_t k = 0; k < 3; ++k) {
        corners[3 * k] = origin[k];
        corners[3 * k + 1] = points[k];
        corners[3 * k + 2] = points[k == 0 ? 2 : k - 1];
        corners[9 + k] = points[k];
    }
}

void split_triangles(const Topology& coarse, Topology& fine) {
    EdgeNumbers numbers(fine);
    for (Index f = 0; f < coarse.face_count; ++f) {
        const Index* across = coarse.twin.data() + 3 * f;
        const Index to = 12 * f;
        set_children(coarse, f, fine.origin.data() + to);
        for (Index k = 0; k < 3; ++k) {
            const Index j = k == 2 ? 0 : k + 1;
            const Index i = k == 0 ? 2 : k - 1;
            // The halves of the edges in front of and behind corner k.
            Index* twin = fine.twin.data() + to + 3 * k;
            twin[0] = across[k] == kNone ? kNone : halves(coarse, Split::Loop, across[k])[1];
            twin[1] = to + 9 + i;
            twin[2] = across[i] == kNone ? kNone : halves(coarse, Split::Loop, across[i])[0];
            fine.twin[to + 9 + k] = to + 3 * j + 1;
        }
        numbers.continue_to(to + 12);
    }
}

/// The child quad h of half-edge h of face f.
void set_child(const Topology& coarse, Index f, Index h, Index prev, Index* corners) {
    const Index edges = coarse.vertex_count;
    corners[0] = coarse.origin[h];
    corners[1] = edges + coarse.edge[h];
    corners[2] = edges + coarse.edge_count + f;
    corners[3] = edges + coarse.edge[prev];
}

/// next_of(h): the next half-edge on the face.
template <class Next>
void split_polygons(const Topology& coarse, Topology& fine, Next next_of) {
    EdgeNumbers numbers(fine);
    each_half_edge(coarse, [&](Index f, Index h, Index next, Index prev) {
        set_child(coarse, f, h, prev, fine.origin.data() + 4 * h);
        const Index across = coarse.twin[h];
        const Index behind = coarse.twin[prev];
        Index* twin = fine.twin.data() + 4 * h;
        twin[0] = across == kNone ? kNone : 4 * next_of(across) + 3;
        twin[1] = 4 * next + 2;
        twin[2] = 4 * prev + 1;
        twin[3] = behind == kNone ? kNone : 4 * behind;
        numbers.continue_to(4 * h + 4);
    });
}

/// sqrt(3) steps. The fine face at half-edge h has the corners origin(h), the point beyond h, and
/// that on its own side. Each coarse face writes what it knows of the fine faces at its half-edges
/// and across them, so that it needs to look at no other face. WithTwins: or corners alone.
template <bool WithTwins>
class Sqrt3 {
  public:
    Sqrt3(const Topology& coarse, Split split, Index* corners, Index* twins)
        : coarse_(coarse), even_(split == Split::Sqrt3Even), corners_(corners), twins_(twins) {
        if (counts_of(coarse).boundary_edges > 0) number_faces();
    }

    void split() {
        Index point = coarse_.vertex_count;
        for (Index f = 0; f < coarse_.face_count; ++f) {
            const Index side = pairs_.size() > 0 && even_ ? boundary_side(coarse_, f) : kNone;
            if (side == kNone) {
                split_face(3 * f, point++);
            } else {
                trisect(side, point);
                point += 2;
            }
        }
    }

  private:
    /// The fine faces at a half-edge and across it, which come together; the one that begins at the
    /// vertex with the smaller number is first.
    struct Pair {
        Index own;
        Index across;
    };
    [[nodiscard]] Index first_face(Index h) const {
        return pairs_.size() > 0 ? pairs_[coarse_.edge[h]] : 2 * coarse_.edge[h];
    }
    [[nodiscard]] Pair pair_at(Index h, Index next) const {
        const Index first = first_face(h);
        const Index descends = coarse_.origin[h] > coarse_.origin[next];
        return {first + descends, first + 1 - descends};
    }

    /// Meshes with boundary: its edges have one face in odd steps, none here in even ones.
    void number_faces() {
        pairs_ = Buffer<Index>(coarse_.edge_count);
        Index count = 0;
        each_edge(coarse_, [&](Index h, Index, Index) {
            pairs_[coarse_.edge[h]] = count;
            count += coarse_.on_boundary(h) ? (even_ ? 0 : 1) : 2;
        });
        middle_ = count;
    }

    void set(Index to, const std::array<Index, 3>& corners) {
        std::copy_n(corners.data(), 3, corners_ + to);
    }
    void link(Index a, Index b) {
        if constexpr (WithTwins) {
            twins_[a] = b;
            twins_[b] = a;
        }
    }
    void end(Index h) {
        if constexpr (WithTwins) twins_[h] = kNone;
    }

    void split_face(Index h, Index point) {
        // Fine half-edges out of each corner to the point, and back from it.
        const std::array<Out, 3> sides{side(h, h + 1, point), side(h + 1, h + 2, point),
                                       side(h + 2, h, point)};
        link(sides[0].back, sides[2].out);
        link(sides[1].back, sides[0].out);
        link(sides[2].back, sides[1].out);
    }

    /// The fine half-edges on one side of a face: out of the end of the coarse one to the point,
    /// and from there back to its origin.
    struct Out {
        Index out;
        Index back;
    };
    Out side(Index h, Index next, Index point) {
        if (pairs_.size() > 0 && coarse_.on_boundary(h)) {
            const Index to = 3 * first_face(h);
            set(to, {coarse_.origin[h], coarse_.origin[next], point});
            end(to);
            return {to + 1, to + 2};
        }
        const Pair pair = pair_at(h, next);
        corners_[3 * pair.own] = coarse_.origin[h];
        corners_[3 * pair.own + 2] = point;
        corners_[3 * pair.across + 1] = point;
        if constexpr (WithTwins) twins_[3 * pair.own + 1] = 3 * pair.across + 1;
        return {3 * pair.across, 3 * pair.own + 2};
    }

    /// The face behind boundary half-edge h, with the points p and p + 1 on it, and the apex c:
    /// (p, p + 1, c) is the last of the fine faces so far.
    void trisect(Index h, Index p) {
        const Index next = next3(h);
        const Index prev = prev3(h);
        const Out far = side(next, prev, p + 1);
        const Out near = side(prev, h, p);
        const Index middle = 3 * middle_++;
        set(middle, {p, p + 1, coarse_.origin[prev]});
        link(far.out, middle + 1);
        link(near.back, middle + 2);
        for (const Index border : {far.back, near.out, middle}) end(border);
    }

    const Topology& coarse_;
    bool even_;
    Index* corners_;
    Index* twins_;
    Buffer<Index> pairs_;  ///< [edge], of meshes with boundary: the first of its fine faces
    Index middle_ = 0;     ///< even steps: the next face in the middle of a boundary edge
};

void split_sqrt3(const Topology& coarse, Split split, Topology& fine) {
    Sqrt3<true>(coarse, split, fine.origin.data(), fine.twin.data()).split();
    EdgeNumbers(fine).continue_to(fine.half_edge_count());
}

Status check_triangles(const Topology& mesh, Split split) {
    if (mesh.sides != 3) {
        Index f = 0;
        while (mesh.size_of(f) == 3) ++f;
        return Error{ErrorCode::BadInput,
                     "not_triangles: it has " + std::to_string(mesh.size_of(f)) +
                         " corners; Loop and sqrt(3) subdivision need triangles, Catmull-Clark "
                         "takes all polygons",
                     "face " + std::to_string(f)};
    }
    if (split != Split::Sqrt3Even || counts_of(mesh).boundary_edges == 0) return {};
    for (Index f = 0; f < mesh.face_count; ++f) {
        int sides = 0;
        for (Index k = 0; k < 3; ++k) sides += mesh.on_boundary(3 * f + k);
        if (sides > 1)
            return Error{ErrorCode::BadInput,
                         "sqrt3_parity: an even sqrt(3) step needs faces with at most one boundary "
                         "edge, as every odd step leaves them; it has " +
                             std::to_string(sides),
                         "face " + std::to_string(f)};
    }
    return {};
}

}  // namespace

MeshCounts counts_of(const Topology& mesh) {
    MeshCounts counts{mesh.vertex_count, mesh.edge_count, mesh.face_count, mesh.half_edge_count()};
    counts.boundary_edges = 2 * counts.edges - counts.half_edges;
    return counts;
}

MeshCounts refined(const MeshCounts& coarse, Split split) {
    MeshCounts fine;
    switch (split) {
        case Split::Loop:
            fine.vertices = coarse.vertices + coarse.edges;
            fine.faces = 4 * coarse.faces;
            fine.half_edges = 3 * fine.faces;
            fine.boundary_edges = 2 * coarse.boundary_edges;
            break;
        case Split::CatmullClark:
            fine.vertices = coarse.vertices + coarse.edges + coarse.faces;
            fine.faces = coarse.half_edges;
            fine.half_edges = 4 * fine.faces;
            fine.boundary_edges = 2 * coarse.boundary_edges;
            break;
        case Split::Sqrt3Odd:
            fine.vertices = coarse.vertices + coarse.faces;
            fine.faces = 3 * coarse.faces;
            fine.half_edges = 3 * fine.faces;
            fine.boundary_edges = coarse.boundary_edges;
            break;
        case Split::Sqrt3Even:
            fine.vertices = coarse.vertices + coarse.faces + coarse.boundary_edges;
            fine.faces = 3 * coarse.faces;
            fine.half_edges = 3 * fine.faces;
            fine.boundary_edges = 3 * coarse.boundary_edges;
            break;
    }
    fine.edges = (fine.half_edges + fine.boundary_edges) / 2;
    return fine;
}

Status check_size(const MeshCounts& counts) {
    if (counts.half_edges <= kMostElements) return {};
    return Error{ErrorCode::BadInput,
                 "too_many_elements: the finer mesh would have " + std::to_string(counts.faces) +
                     " faces; the corners of all faces must be fewer than 2^31",
                 "mesh"};
}

Status check_split(const Topology& coarse, Split split) {
    if (split != Split::CatmullClark) RELIEF_CHECK(check_triangles(coarse, split));
    return check_size(refined(counts_of(coarse), split));
}

Status refine(const Topology& coarse, Split split, Topology& fine) {
    RELIEF_CHECK(check_split(coarse, split));
    const MeshCounts counts = refined(counts_of(coarse), split);
    fine.vertex_count = static_cast<Index>(counts.vertices);
    fine.edge_count = static_cast<Index>(counts.edges);
    fine.face_count = static_cast<Index>(counts.faces);
    fine.sides = sides_after(split);
    for (Buffer<Index>* buffer : {&fine.origin, &fine.twin, &fine.edge})
        buffer->renew(counts.half_edges);
    if (split == Split::Loop)
        split_triangles(coarse, fine);
    else if (split != Split::CatmullClark)
        split_sqrt3(coarse, split, fine);
    else if (coarse.sides == 4)
        split_polygons(coarse, fine, [](Index h) { return h % 4 == 3 ? h - 3 : h + 1; });
    else
        split_polygons(coarse, fine, [&](Index h) { return coarse.next(h); });
    return {};
}

Result<Topology> refine(const Topology& coarse, Split split) {
    Topology fine;
    RELIEF_CHECK(refine(coarse, split, fine));
    return fine;
}

void split_faces(const Topology& coarse, Split split, std::span<Index> corners) {
    Index* to = corners.data();
    if (split == Split::Loop) {
        for (Index f = 0; f < coarse.face_count; ++f, to += 12) set_children(coarse, f, to);
        return;
    }
    if (split == Split::CatmullClark) {
        each_half_edge(coarse, [&](Index f, Index h, Index, Index prev) {
            set_child(coarse, f, h, prev, to + 4 * h);
        });
        return;
    }
    Sqrt3<false>(coarse, split, to, nullptr).split();
}

FacePoints face_points(const Topology& coarse, Split split) {
    FacePoints points;
    points.first = coarse.vertex_count;
    if (split == Split::CatmullClark) points.first += coarse.edge_count;
    if (split != Split::Sqrt3Even || counts_of(coarse).boundary_edges == 0) return points;
    points.of_face = Buffer<Index>(coarse.face_count);
    Index vertex = points.first;
    for (Index f = 0; f < coarse.face_count; ++f) {
        points.of_face[f] = vertex;
        vertex += boundary_side(coarse, f) == kNone ? 1 : 2;
    }
    return points;
}

Buffer<Index> sqrt3_faces(const Topology& coarse, Split split) {
    const bool even = split == Split::Sqrt3Even;
    Buffer<Index> faces(coarse.half_edge_count());
    if (counts_of(coarse).boundary_edges == 0) {
        each_half_edge(coarse, [&](Index, Index h, Index next, Index) {
            faces[h] = 2 * coarse.edge[h] + (coarse.origin[h] > coarse.origin[next]);
        });
        return faces;
    }
    Index count = 0;
    for (Index h = 0; h < coarse.half_edge_count(); ++h) {
        if (!coarse.is_first(h)) continue;
        const Index twin = coarse.twin[h];
        if (twin == kNone) {
            if (!even) faces[h] = count++;
            continue;
        }
        const bool ascends = coarse.origin[h] < coarse.origin[next3(h)];
        faces[h] = ascends ? count : count + 1;
        faces[twin] = ascends ? count + 1 : count;
        count += 2;
    }
    for (Index h = 0; even && h < coarse.half_edge_count(); ++h)
        if (coarse.on_boundary(h)) faces[h] = count++;
    return faces;
}

Index boundary_side(const Topology& triangles, Index f) {
    for (Index h = 3 * f; h < 3 * f + 3; ++h)
        if (triangles.on_boundary(h)) return h;
    return kNone;
}

}  // namespace relief::mesh
