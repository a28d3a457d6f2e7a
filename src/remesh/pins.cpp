#include "remesh/pins.h"

#include <algorithm>

#include "remesh/relax.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using mesh::kNone;

/// Faces around a vertex that is pinned fit at least so well, or not worse than before.
constexpr double kLeastFit = 0.05;
constexpr std::size_t kMostPins = 1000;
/// Pins of one round are so far apart, in mean edges.
constexpr double kApart = 2;

double worst_fit(const MovingMesh& mesh, Index v) {
    double worst = 1;
    for (const Index c : mesh.corners_at(v)) worst = std::min(worst, mesh.fit(c / 3));
    return worst;
}

/// Moves that vertex of the faces at a corner of `face` to a place that the faces around it like
/// best. False: none may go there.
bool pin(MovingMesh& mesh, Index face, const Place& place) {
    Index best = kNone;
    double best_fit = -1;
    std::vector<Index> tried;
    for (Index k = 0; k < 3; ++k)
        for (const Index c : mesh.corners_at(mesh.corners[3 * face + k]))
            for (Index j = 0; j < 3; ++j) tried.push_back(mesh.corners[c / 3 * 3 + j]);
    std::sort(tried.begin(), tried.end());
    tried.erase(std::unique(tried.begin(), tried.end()), tried.end());
    for (const Index v : tried) {
        if (mesh.fixed[v]) continue;
        const Place before = mesh.places[v];
        const double least = std::min(kLeastFit, worst_fit(mesh, v));
        mesh.put(v, place);
        const double fit = worst_fit(mesh, v);
        mesh.put(v, before);
        if (fit <= 0 || fit < least || fit <= best_fit) continue;
        best = v;
        best_fit = fit;
    }
    if (best == kNone) return false;
    mesh.put(best, place);
    mesh.fixed[best] = 1;
    return true;
}

}  // namespace

std::vector<Index> far_vertices(const Surface& surface, std::span<const double> distances,
                                double tolerance, double apart, std::size_t most) {
    std::vector<Index> order;
    for (Index v = 0; v < distances.size(); ++v)
        if (distances[v] > tolerance) order.push_back(v);
    std::sort(order.begin(), order.end(), [&](Index a, Index b) {
        return distances[a] != distances[b] ? distances[a] > distances[b] : a < b;
    });
    std::vector<Index> chosen;
    for (const Index v : order) {
        if (chosen.size() == most) break;
        const bool near = std::any_of(chosen.begin(), chosen.end(), [&](Index u) {
            const double reach = std::max(apart, 2 * distances[u]);
            const Vec3<double> off = surface.points[v] - surface.points[u];
            return dot(off, off) < reach * reach;
        });
        if (!near) chosen.push_back(v);
    }
    return chosen;
}

std::size_t pin_far_vertices(MovingMesh& mesh, double tolerance) {
    const Surface& surface = *mesh.surface;
    const Buffer<Index> out = mesh::outgoing(surface.mesh);
    double edge = 0;
    for (const double size : mesh.edge_lengths()) edge += size;
    edge /= static_cast<double>(mesh.points.size());
    const Reverse reverse = distances_from(mesh);
    std::size_t pinned = 0;
    for (const Index v :
         far_vertices(surface, reverse.distances, tolerance, kApart * edge, kMostPins)) {
        Place place{out[v] / 3, {0, 0, 0}};
        place.weights[out[v] % 3] = 1;
        pinned += pin(mesh, reverse.faces[v], place);
    }
    return pinned;
}

}  // namespace relief::remesh
