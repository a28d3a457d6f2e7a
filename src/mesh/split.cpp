#include "relief/mesh/split.h"

#include <algorithm>
#include <string>

#include "mesh/twins.h"

namespace relief::mesh {

namespace {

constexpr std::uint64_t kMostElements = (std::uint64_t{1} << 31) - 1;

Index next3(Index h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}
Index prev3(Index h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}

Topology allocate(const MeshCounts& counts, int sides) {
    Topology mesh;
    mesh.vertex_count = static_cast<Index>(counts.vertices);
    mesh.edge_count = static_cast<Index>(counts.edges);
    mesh.face_count = static_cast<Index>(counts.faces);
    mesh.sides = sides;
    mesh.origin = Buffer<Index>(counts.half_edges);
    mesh.twin = Buffer<Index>(counts.half_edges);
    return mesh;
}

/// Triangle f has the children 4f .. 4f + 3.
void split_triangles(const Topology& coarse, Topology& fine) {
    const Index first_new = coarse.vertex_count;
    for (Index f = 0; f < coarse.face_count; ++f) {
        const Index h = 3 * f;
        const Index to = 4 * h;
        std::array<Index, 3> points{};
        for (Index k = 0; k < 3; ++k) points[k] = first_new + coarse.edge[h + k];
        for (Index k = 0; k < 3; ++k) {
            const Index j = k == 2 ? 0 : k + 1;
            const Index i = k == 0 ? 2 : k - 1;
            Index* origin = fine.origin.data() + to + 3 * k;
            origin[0] = coarse.origin[h + k];
            origin[1] = points[k];
            origin[2] = points[i];
            fine.origin[to + 9 + k] = points[k];
            // The halves of the edges in front of and behind corner k.
            const Index across = coarse.twin[h + k];
            const Index behind = coarse.twin[h + i];
            Index* twin = fine.twin.data() + to + 3 * k;
            twin[0] = across == kNone ? kNone : 12 * (across / 3) + 3 * (next3(across) % 3) + 2;
            twin[1] = to + 9 + i;
            twin[2] = behind == kNone ? kNone : 12 * (behind / 3) + 3 * (behind % 3);
            fine.twin[to + 9 + k] = to + 3 * j + 1;
        }
    }
}

/// Half-edge h has the child quad h.
void split_polygons(const Topology& coarse, Topology& fine) {
    const Index edges = coarse.vertex_count;
    const Index faces = edges + coarse.edge_count;
    for (Index f = 0; f < coarse.face_count; ++f) {
        const Index begin = coarse.first_of(f);
        const Index end = coarse.first_of(f + 1);
        for (Index h = begin; h < end; ++h) {
            const Index next = h + 1 == end ? begin : h + 1;
            const Index prev = h == begin ? end - 1 : h - 1;
            Index* origin = fine.origin.data() + 4 * h;
            origin[0] = coarse.origin[h];
            origin[1] = edges + coarse.edge[h];
            origin[2] = faces + f;
            origin[3] = edges + coarse.edge[prev];
            const Index across = coarse.twin[h];
            const Index behind = coarse.twin[prev];
            Index* twin = fine.twin.data() + 4 * h;
            twin[0] = across == kNone ? kNone : 4 * coarse.next(across) + 3;
            twin[1] = 4 * next + 2;
            twin[2] = 4 * prev + 1;
            twin[3] = behind == kNone ? kNone : 4 * behind;
        }
    }
}

/// sqrt(3) steps: the fine face at half-edge h has the corners origin(h), the point beyond h, and
/// that on its own side.
class Sqrt3 {
  public:
    Sqrt3(const Topology& coarse, Split split, Topology& fine)
        : coarse_(coarse),
          even_(split == Split::Sqrt3Even),
          fine_(fine),
          points_(face_points(coarse, split)),
          faces_(sqrt3_faces(coarse, split)) {}

    void split() {
        for (Index h = 0; h < coarse_.half_edge_count(); ++h)
            if (!coarse_.on_boundary(h))
                inner_face(h);
            else if (!even_)
                boundary_face(h);
            else
                middle_face(h);
    }

  private:
    /// The side of the face of h that is trisected.
    [[nodiscard]] Index trisected(Index h) const {
        return even_ ? boundary_side(coarse_, h / 3) : kNone;
    }

    /// The new point on the side of h that its flipped edge leads to.
    [[nodiscard]] Index point(Index h) const {
        const Index side = trisected(h);
        return points_[h / 3] + (side != kNone && h == next3(side) ? 1 : 0);
    }

    /// The fine half-edge from origin(h) into the face of h, whose side `h` was: twin of the one
    /// that comes out of it.
    [[nodiscard]] Index from_origin(Index h) const {
        const Index before = prev3(h);
        if (coarse_.on_boundary(before)) return 3 * faces_[before] + 1;
        return 3 * faces_[coarse_.twin[before]];
    }

    void set(Index face, std::array<Index, 3> corners, std::array<Index, 3> twins) {
        std::copy_n(corners.data(), 3, fine_.origin.data() + 3 * face);
        std::copy_n(twins.data(), 3, fine_.twin.data() + 3 * face);
    }

    void inner_face(Index h) {
        const Index twin = coarse_.twin[h];
        Index begin = 3 * faces_[next3(twin)] + 2;
        if (const Index side = trisected(twin); side != kNone)
            begin = twin == next3(side) ? 3 * faces_[side] + 1 : kNone;
        Index end = from_origin(h);
        if (const Index side = trisected(h); side != kNone)
            end = h == prev3(side) ? 3 * faces_[side] + 2 : kNone;
        set(faces_[h], {coarse_.origin[h], point(twin), point(h)},
            {begin, 3 * faces_[twin] + 1, end});
    }

    /// (a, b, L)
    void boundary_face(Index h) {
        set(faces_[h], {coarse_.origin[h], coarse_.origin[next3(h)], points_[h / 3]},
            {kNone, 3 * faces_[next3(h)] + 2, from_origin(h)});
    }

    /// (p, q, c)
    void middle_face(Index h) {
        const Index p = points_[h / 3];
        set(faces_[h], {p, p + 1, coarse_.origin[prev3(h)]},
            {kNone, 3 * faces_[coarse_.twin[next3(h)]], 3 * faces_[prev3(h)] + 2});
    }

    const Topology& coarse_;
    bool even_;
    Topology& fine_;
    FacePoints points_;
    Buffer<Index> faces_;
};

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
    if (split != Split::Sqrt3Even) return {};
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

Result<Topology> refine(const Topology& coarse, Split split) {
    if (split != Split::CatmullClark) RELIEF_CHECK(check_triangles(coarse, split));
    const MeshCounts counts = refined(counts_of(coarse), split);
    RELIEF_CHECK(check_size(counts));
    Topology fine = allocate(counts, split == Split::CatmullClark ? 4 : 3);
    switch (split) {
        case Split::Loop:
            split_triangles(coarse, fine);
            break;
        case Split::CatmullClark:
            split_polygons(coarse, fine);
            break;
        case Split::Sqrt3Odd:
        case Split::Sqrt3Even:
            Sqrt3(coarse, split, fine).split();
            break;
    }
    number_edges(fine);
    return fine;
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
