#pragma once

#include <utility>

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
    each_half_edge(mesh, [&](Index, Index h, Index next, Index prev) {
        if (mesh.is_first(h)) visit(h, next, prev);
    });
}

}  // namespace relief::mesh
