#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "relief/core/buffer.h"
#include "relief/core/result.h"
#include "relief/mesh/index.h"

/// Which faces of a mesh meet where: half-edges. Source: reverse-subdivision.md section 2.
namespace relief::mesh {

/// An oriented manifold surface of triangles, quads or polygons, with or without boundary, of any
/// number of components. Half-edge h runs along a side of a face, counter-clockwise; those of a
/// face follow each other. Invariant: made by `build` or `refine`: every edge has one or two faces,
/// which run along it in opposite directions, every vertex has a face and the faces at it form one
/// fan, the corners of a face differ.
struct Topology {
    Index vertex_count = 0;
    Index edge_count = 0;
    Index face_count = 0;
    int sides = 3;         ///< of every face: 3 or 4; 0: as many as `first` says
    Buffer<Index> origin;  ///< of half-edge h: where it begins; so this is the list of faces
    Buffer<Index> twin;    ///< the half-edge of the other face; kNone on the boundary
    Buffer<Index> edge;    ///< numbered in the order of their first half-edges
    Buffer<Index> first;   ///< sides = 0: the first half-edge of each face, and their number
    Buffer<Index> face;    ///< sides = 0: of half-edge h

    [[nodiscard]] Index half_edge_count() const { return static_cast<Index>(origin.size()); }
    [[nodiscard]] Index first_of(Index f) const {
        return sides ? f * static_cast<Index>(sides) : first[f];
    }
    [[nodiscard]] Index face_of(Index h) const {
        return sides ? h / static_cast<Index>(sides) : face[h];
    }
    [[nodiscard]] Index size_of(Index f) const { return first_of(f + 1) - first_of(f); }
    [[nodiscard]] Index next(Index h) const {
        const Index f = face_of(h);
        return h + 1 == first_of(f + 1) ? first_of(f) : h + 1;
    }
    [[nodiscard]] Index prev(Index h) const {
        const Index f = face_of(h);
        return h == first_of(f) ? first_of(f + 1) - 1 : h - 1;
    }
    /// Where half-edge h ends.
    [[nodiscard]] Index target(Index h) const { return origin[next(h)]; }
    [[nodiscard]] bool on_boundary(Index h) const { return twin[h] == kNone; }
    /// The one of the two half-edges of an edge after which it is numbered.
    [[nodiscard]] bool is_first(Index h) const { return h < twin[h]; }
    [[nodiscard]] std::span<const Index> corners(Index f) const {
        return {origin.data() + first_of(f), size_of(f)};
    }
};

/// Faces as lists of corners: face k has the corners corners[offsets[k]] .. corners[offsets[k + 1]
/// - 1].
struct FaceList {
    std::vector<std::int64_t> offsets = {0};
    std::vector<Index> corners;

    [[nodiscard]] std::size_t size() const { return offsets.size() - 1; }
    [[nodiscard]] std::span<const Index> operator[](std::size_t k) const {
        const auto begin = static_cast<std::size_t>(offsets[k]);
        return std::span(corners).subspan(begin, static_cast<std::size_t>(offsets[k + 1]) - begin);
    }
    void add(std::span<const Index> face) {
        corners.insert(corners.end(), face.begin(), face.end());
        offsets.push_back(static_cast<std::int64_t>(corners.size()));
    }
    friend bool operator==(const FaceList&, const FaceList&) = default;
};
[[nodiscard]] FaceList faces_of(const Topology& mesh);

/// Errors, all BadInput: the message begins with one of these names, and `where` names the element:
/// `empty_mesh`, `index_out_of_range`, `too_few_corners`, `repeated_corner`, `unused_vertex`,
/// `too_many_elements`; `non_manifold_edge` (three faces, or two that run along it in the same
/// direction: then they are oriented differently or equal), `non_manifold_vertex` (two fans meet).
/// Complexity: O(n).
[[nodiscard]] Result<Topology> build(std::span<const std::int64_t> offsets,
                                     std::span<const Index> corners, Index vertex_count);
[[nodiscard]] Result<Topology> build(const FaceList& faces, Index vertex_count);

/// For each vertex a half-edge that begins there: on the boundary the one without twin. So
/// h, rotated(h), .. are all those of the fan, counter-clockwise, each once.
[[nodiscard]] Buffer<Index> outgoing(const Topology& mesh);

/// The next half-edge that begins where h does, counter-clockwise; kNone behind the last of a fan.
[[nodiscard]] inline Index rotated(const Topology& mesh, Index h) {
    return mesh.twin[mesh.prev(h)];
}

/// The number of edges at each vertex.
[[nodiscard]] Buffer<Index> valences(const Topology& mesh);

/// The component of each face, numbered in the order of their first faces, and how many there are.
struct Components {
    std::vector<Index> of_face;
    Index count = 0;
};
[[nodiscard]] Components components(const Topology& mesh);

/// The Euler characteristic: vertices - edges + faces.
[[nodiscard]] std::int64_t euler_characteristic(const Topology& mesh);

}  // namespace relief::mesh
