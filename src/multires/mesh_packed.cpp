#include "relief/multires/mesh_packed.h"

#include "multires/mesh_points.h"
#include "multires/stiff_system.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;
using Points = std::vector<Vec3<double>>;

/// Of the details of an edge in the sum of its ends, s_e, times this is 1.
double share_of_edge(bool sharp) {
    return sharp ? rules::kSharpEdgeEnd : rules::kQuadEdgeEnd;
}

/// visit(place of the stiff vertex, half-edge, whether it is sharp): first half-edges of the edges
/// at stiff vertices, in order.
template <class Visit>
void each_stiff_edge(const MeshStep<double>& step, Visit&& visit) {
    const mesh::Topology& mesh = step.coarse();
    const std::vector<Index>& stiff = step.rules().stiff.vertices;
    std::vector<Index> place(mesh.vertex_count, kNone);
    for (std::size_t k = 0; k < stiff.size(); ++k) place[stiff[k]] = static_cast<Index>(k);
    mesh::each_edge(mesh, [&](Index h, Index next, Index) {
        for (const Index end : {mesh.origin[h], mesh.origin[next]})
            if (place[end] != kNone) visit(place[end], h, is_sharp(step.rules(), mesh, h));
    });
}

/// details += sign x (residuals, spread).
void spread(const MeshStep<double>& step, double sign, const Vec3<double>* residuals,
            Vec3<double>* details) {
    each_stiff_edge(step, [&](Index place, Index h, bool sharp) {
        details[step.coarse().edge[h]] += sign * share_of_edge(sharp) * residuals[place];
    });
}

}  // namespace

Status check_packed(const StepRules& rules) {
    if (rules.stiff.alternating.empty()) return {};
    const auto& component = rules.stiff.alternating.front();
    return Error{
        ErrorCode::BadInput,
        "not_reversible: all vertices of a component have three edges and its edges join "
        "two classes of vertices; keep residuals beside the details, or one level less",
        "component of vertex " + std::to_string(rules.stiff.vertices[component.places.front()])};
}

void pack_residuals(const MeshStep<double>& step, const Vec3<double>* residuals,
                    Vec3<double>* details) {
    spread(step, 1, residuals, details);
}

void unpack_residuals(const MeshStep<double>& step, Vec3<double>* details,
                      Vec3<double>* residuals) {
    const mesh::Topology& mesh = step.coarse();
    const Vec3<double>* faces = details + mesh.edge_count;
    Points sums(step.rules().stiff.size());
    each_stiff_edge(step, [&](Index place, Index h, bool sharp) {
        sums[place] += 1 / share_of_edge(sharp) * details[mesh.edge[h]];
        if (!sharp) sums[place] -= faces[mesh.face_of(h)] + faces[mesh.face_of(mesh.twin[h])];
    });
    const Points solution = solve_stiff_system<double>(step.rules().stiff, sums);
    std::copy(solution.begin(), solution.end(), residuals);
    spread(step, -1, residuals, details);
}

}  // namespace relief::multires
