#include "relief/multires/mesh_smooth.h"

#include "multires/conjugate_gradient.h"
#include "relief/mesh/walk.h"

namespace relief::multires {

namespace {

using mesh::Index;

}  // namespace

Result<MeshSmoothing> MeshSmoothing::create(const MeshStep<double>& step, double omega) {
    if (!(omega > 0 && omega <= 1))
        return Error{ErrorCode::InvalidArgument,
                     "invalid_parameter: omega must be above 0 and at most 1", "omega"};
    return MeshSmoothing(step, omega);
}

MeshSmoothing::MeshSmoothing(const MeshStep<double>& step, double omega)
    : step_(&step), omega_(omega), shares_(step.coarse_count(), 0.0) {
    const mesh::Topology& mesh = step.coarse();
    mesh::each_half_edge(mesh, [&](Index, Index h, Index, Index) { ++shares_[mesh.origin[h]]; });
    for (Index v = 0; v < mesh.vertex_count; ++v)
        shares_[v] = step.rules().kinds[v] <= VertexKind::Dart ? 1 / shares_[v] : 0;
}

void MeshSmoothing::keep_inner(Points& c) const {
    for (std::size_t v = 0; v < c.size(); ++v)
        if (shares_[v] == 0) c[v] = {};
}

/// P^T P c, of inner vertices.
MeshSmoothing::Points MeshSmoothing::nearness(const Points& c) const {
    Points old(step_->coarse_count());
    Points fresh(step_->new_count());
    Points image(c.size());
    step_->apply(c.data(), old.data(), fresh.data());
    step_->adjoint(old.data(), fresh.data(), image.data());
    keep_inner(image);
    return image;
}

/// U^T U c, of inner vertices.
MeshSmoothing::Points MeshSmoothing::roughness(const Points& c) const {
    const mesh::Topology& mesh = step_->coarse();
    Points umbrellas = c;
    keep_inner(umbrellas);
    mesh::each_half_edge(mesh, [&](Index, Index h, Index next, Index) {
        const Index v = mesh.origin[h];
        umbrellas[v] -= shares_[v] * c[mesh.origin[next]];
    });
    Points image = umbrellas;
    mesh::each_half_edge(mesh, [&](Index, Index h, Index next, Index) {
        const Index v = mesh.origin[h];
        image[mesh.origin[next]] -= shares_[v] * umbrellas[v];
    });
    keep_inner(image);
    return image;
}

void MeshSmoothing::smooth(Vec3<double>* c) const {
    Points rough = roughness({c, c + step_->coarse_count()});
    for (auto& r : rough) r = (omega_ - 1) * r;
    const Points move = conjugate_gradient<double>(rough, [&](const Points& x, Points& y) {
        y = nearness(x);
        const Points bent = roughness(x);
        for (std::size_t v = 0; v < y.size(); ++v) y[v] = omega_ * y[v] + (1 - omega_) * bent[v];
    });
    for (std::size_t v = 0; v < move.size(); ++v) c[v] += move[v];
}

void MeshSmoothing::restore(Vec3<double>* c) const {
    Points rough = roughness({c, c + step_->coarse_count()});
    for (auto& r : rough) r = (1 - omega_) / omega_ * r;
    const StiffVertices& stiff = step_->rules().stiff;
    for (const auto& component : stiff.alternating) {
        Vec3<double> mean;
        const double count = static_cast<double>(component.places.size());
        for (std::size_t k = 0; k < component.places.size(); ++k)
            mean += component.signs[k] / count * rough[stiff.vertices[component.places[k]]];
        for (std::size_t k = 0; k < component.places.size(); ++k)
            rough[stiff.vertices[component.places[k]]] -=
                static_cast<double>(component.signs[k]) * mean;
    }
    const Points move =
        conjugate_gradient<double>(rough, [&](const Points& x, Points& y) { y = nearness(x); });
    for (std::size_t v = 0; v < move.size(); ++v) c[v] += move[v];
}

}  // namespace relief::multires
