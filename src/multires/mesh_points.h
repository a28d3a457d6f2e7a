#pragma once

#include "relief/mesh/walk.h"
#include "relief/multires/mesh_step.h"

/// Which new vertices are around an old one.
namespace relief::multires {

[[nodiscard]] inline bool is_sharp(const StepRules& rules, const mesh::Topology& mesh,
                                   mesh::Index h) {
    return mesh.on_boundary(h) || (!rules.sharp.empty() && rules.sharp[mesh.edge[h]] != 0);
}

/// The place of the new vertex of a face among the new ones; sqrt(3), Catmull-Clark.
[[nodiscard]] inline mesh::Index face_point(const mesh::Topology& mesh, const StepRules& rules,
                                            mesh::Index f) {
    return rules.face_points[f] - mesh.vertex_count;
}

/// Even sqrt(3) steps: faces with a boundary edge have two points on it instead of their own.
[[nodiscard]] inline bool is_trisected(const mesh::Topology& mesh, const StepRules& rules,
                                       mesh::Index f) {
    return !rules.trisections.empty() && mesh::boundary_side(mesh, f) != mesh::kNone;
}

/// visit(vertex, point, share of the vertex's weight): what K looks at around each vertex. The
/// share is 1, and -1/4 for the faces of Catmull-Clark.
template <class T, class Visit>
void each_point_around(const mesh::Topology& mesh, const StepRules& rules, Visit&& visit) {
    using mesh::Index;
    if (rules.split == mesh::Split::Loop || rules.split == mesh::Split::CatmullClark) {
        mesh::each_edge(mesh, [&](Index h, Index next, Index) {
            visit(mesh.origin[h], mesh.edge[h], T{1});
            visit(mesh.origin[next], mesh.edge[h], T{1});
        });
        if (rules.split == mesh::Split::Loop) return;
        mesh::each_half_edge(mesh, [&](Index f, Index h, Index, Index) {
            visit(mesh.origin[h], mesh.edge_count + f, T{-0.25});
        });
        return;
    }
    for (Index f = 0; f < mesh.face_count; ++f) {
        if (is_trisected(mesh, rules, f)) continue;
        const Index point = face_point(mesh, rules, f);
        for (Index h = 3 * f; h < 3 * f + 3; ++h) visit(mesh.origin[h], point, T{1});
    }
}

}  // namespace relief::multires
