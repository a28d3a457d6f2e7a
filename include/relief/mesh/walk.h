#pragma once

#include <algorithm>
#include <array>

#include "relief/mesh/topology.h"

/// Loops over all half-edges of a mesh whose neighbours on the face cost no look-up.
namespace relief::mesh {

namespace detail {

template <Index Sides, class Visit>
void walk(Index faces, Visit& visit) {
    for (Index f = 0; f < faces; ++f)
        for (Index k = 0; k < Sides; ++k) {
            const Index h = Sides * f;
            visit(f, h + k, h + (k + 1 == Sides ? 0 : k + 1), h + (k == 0 ? Sides - 1 : k - 1));
        }
}

template <class Visit>
void walk_polygons(const Topology& mesh, Visit& visit) {
    for (Index f = 0; f < mesh.face_count; ++f) {
        const Index begin = mesh.first_of(f);
        const Index end = mesh.first_of(f + 1);
        for (Index h = begin; h < end; ++h)
            visit(f, h, h + 1 == end ? begin : h + 1, h == begin ? end - 1 : h - 1);
    }
}

template <Index Sides>
Index next_on_face(Index h) {
    return h % Sides + 1 == Sides ? h - (Sides - 1) : h + 1;
}
template <Index Sides>
Index prev_on_face(Index h) {
    return h % Sides == 0 ? h + (Sides - 1) : h - 1;
}

/// Whether a half-edge is the first of its edge can not be guessed: so they are listed without
/// branches, block by block, and visited then.
template <Index Sides, class Visit>
void walk_edges(const Topology& mesh, Visit& visit) {
    constexpr Index block = 1024;
    std::array<Index, block> list;
    const Index* twin = mesh.twin.data();
    const Index end = mesh.half_edge_count();
    for (Index begin = 0; begin < end; begin += block) {
        Index count = 0;
        for (Index h = begin; h < std::min(begin + block, end); ++h) {
            list[count] = h;
            count += h < twin[h];
        }
        for (Index k = 0; k < count; ++k)
            visit(list[k], next_on_face<Sides>(list[k]), prev_on_face<Sides>(list[k]));
    }
}

}  // namespace detail

/// visit(face, half-edge, the next and the previous one on the face), in order.
template <class Visit>
void each_half_edge(const Topology& mesh, Visit&& visit) {
    if (mesh.sides == 3) return detail::walk<3>(mesh.face_count, visit);
    if (mesh.sides == 4) return detail::walk<4>(mesh.face_count, visit);
    detail::walk_polygons(mesh, visit);
}

/// visit(half-edge, next, previous) for the first half-edge of each edge: in the order of edges.
template <class Visit>
void each_edge(const Topology& mesh, Visit&& visit) {
    if (mesh.sides == 3) return detail::walk_edges<3>(mesh, visit);
    if (mesh.sides == 4) return detail::walk_edges<4>(mesh, visit);
    each_half_edge(mesh, [&](Index, Index h, Index next, Index prev) {
        if (mesh.is_first(h)) visit(h, next, prev);
    });
}

}  // namespace relief::mesh
