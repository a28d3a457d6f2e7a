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

/// The numbers of the fine faces of sqrt(3) steps.
class Sqrt3Faces {
  public:
    /// Those at a half-edge inside and at its twin: they follow each other, first the one that
    /// begins at the vertex with the smaller number.
    struct Pair {
        Index own;
        Index across;
    };

    Sqrt3Faces(const Topology& coarse, bool even) : coarse_(coarse) {
        if (counts_of(coarse).boundary_edges == 0) return;
        first_ = Buffer<Index>(coarse.edge_count);
        Index edge = 0;
        Index count = 0;
        const auto continue_to = [&](Index end) {
            for (; edge < end; ++edge, count += 2) first_[edge] = count;
        };
        for (Index h = 0; h < coarse.half_edge_count(); ++h) {
            if (!coarse.on_boundary(h)) continue;
            continue_to(coarse.edge[h] + 1);
            count -= even ? 2 : 1;  // its edge has no two
        }
        continue_to(coarse.edge_count);
        first_middle_ = count;
    }

    [[nodiscard]] bool on_boundary(Index h) const {
        return first_.size() > 0 && coarse_.on_boundary(h);
    }
    /// The first of those of an edge.
    [[nodiscard]] Index first(Index h) const {
        return first_.size() > 0 ? first_[coarse_.edge[h]] : 2 * coarse_.edge[h];
    }
    [[nodiscard]] Pair pair(Index h, Index next) const {
        const Index begin = first(h);
        const Index descends = coarse_.origin[h] > coarse_.origin[next];
        return {begin + descends, begin + 1 - descends};
    }
    /// Even steps: the first of those in the middle of boundary edges, which are in the order of
    /// half-edges.
    [[nodiscard]] Index first_middle() const { return first_middle_; }

  private:
    const Topology& coarse_;
    Buffer<Index> first_;  ///< [edge], of meshes with boundary
    Index first_middle_ = 0;
};

/// sqrt(3) steps. The fine face at half-edge h has the corners origin(h), the point beyond h, and
/// that on its own side. Each coarse face writes what it knows of the fine faces at its half-edges
/// and across them, so that it needs to look at no other face. WithTwins: or corners alone.
template <bool WithTwins>
class Sqrt3 {
  public:
    Sqrt3(const Topology& coarse, Split split, Index* corners, Index* twins)
        : coarse_(coarse),
          even_(split == Split::Sqrt3Even),
          faces_(coarse, even_),
          middle_(faces_.first_middle()),
          corners_(corners),
          twins_(twins) {}

    void split() {
        const bool trisects = even_ && counts_of(coarse_).boundary_edges > 0;
        Index point = coarse_.vertex_count;
        for (Index f = 0; f < coarse_.face_count; ++f) {
            const Index side = trisects ? boundary_side(coarse_, f) : kNone;
            if (side == kNone) {
                split_face(3 * f, point++);
            } else {
                trisect(side, point);
                point += 2;
            }
        }
    }

  private:
    /// The fine half-edges between the point of a face and one of its sides: to the point from the
    /// end of the side, and from it to the origin.
    struct Spokes {
        Index to;
        Index from;
    };

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

    Spokes set_side(Index h, Index next, Index point) {
        if (faces_.on_boundary(h)) {
            const Index face = 3 * faces_.first(h);
            set(face, {coarse_.origin[h], coarse_.origin[next], point});
            end(face);
            return {face + 1, face + 2};
        }
        const Sqrt3Faces::Pair pair = faces_.pair(h, next);
        const Index own = 3 * pair.own;
        const Index across = 3 * pair.across;
        corners_[own] = coarse_.origin[h];
        corners_[own + 2] = point;
        corners_[across + 1] = point;
        if constexpr (WithTwins) twins_[own + 1] = across + 1;
        return {across, own + 2};
    }

    void split_face(Index h, Index point) {
        const Spokes first = set_side(h, h + 1, point);
        const Spokes second = set_side(h + 1, h + 2, point);
        const Spokes third = set_side(h + 2, h, point);
        link(first.from, third.to);
        link(second.from, first.to);
        link(third.from, second.to);
    }

    /// The face behind boundary half-edge h, with the points p and p + 1 on it and the apex c: in
    /// the middle is (p, p + 1, c).
    void trisect(Index h, Index p) {
        const Index next = next3(h);
        const Index prev = prev3(h);
        const Spokes far = set_side(next, prev, p + 1);
        const Spokes near = set_side(prev, h, p);
        const Index middle = 3 * middle_++;
        set(middle, {p, p + 1, coarse_.origin[prev]});
        link(far.to, middle + 1);
        link(near.from, middle + 2);
        for (const Index border : {far.from, near.to, middle}) end(border);
    }

    const Topology& coarse_;
    bool even_;
    Sqrt3Faces faces_;
    Index middle_;  ///< the next face in the middle of a boundary edge
    Index* corners_;
    Index* twins_;
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
    const Sqrt3Faces numbers(coarse, even);
    Index middle = numbers.first_middle();
    Buffer<Index> faces(coarse.half_edge_count());
    each_half_edge(coarse, [&](Index, Index h, Index next, Index) {
        if (numbers.on_boundary(h))
            faces[h] = even ? middle++ : numbers.first(h);
        else
            faces[h] = numbers.pair(h, next).own;
    });
    return faces;
}

Index boundary_side(const Topology& triangles, Index f) {
    for (Index h = 3 * f; h < 3 * f + 3; ++h)
        if (triangles.on_boundary(h)) return h;
    return kNone;
}

}  // namespace relief::mesh
