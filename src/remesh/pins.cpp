#include "remesh/pins.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "relief/core/parallel.h"
#include "remesh/local_search.h"
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

/// The points of a face that are measured, besides its corners: inside and on its sides.
constexpr std::array<std::array<double, 3>, 7> kSamples = {{{1.0 / 3, 1.0 / 3, 1.0 / 3},
                                                            {0.6, 0.2, 0.2},
                                                            {0.2, 0.6, 0.2},
                                                            {0.2, 0.2, 0.6},
                                                            {0.5, 0.5, 0},
                                                            {0, 0.5, 0.5},
                                                            {0.5, 0, 0.5}}};
constexpr int kNearRounds = 4;
constexpr std::int64_t kGrain = 256;

/// Of the farthest of them; nothing below `enough` matters. near: a triangle of the tree where to
/// begin, and the one that was closest last.
double distance_of(const MovingMesh& mesh, const mesh::TriangleTree& tree, Index face,
                   double enough, Index& near) {
    const Index* v = mesh.corners.data() + 3 * face;
    double most = enough;
    for (const auto& w : kSamples) {
        const Vec3<double> sample =
            w[0] * mesh.points[v[0]] + w[1] * mesh.points[v[1]] + w[2] * mesh.points[v[2]];
        const mesh::SurfacePoint closest = tree.closest_from(near, sample, enough);
        near = closest.triangle;
        most = std::max(most, closest.distance);
    }
    return most;
}

/// Those of some faces that are farther than the tolerance.
std::vector<Index> far_faces(const MovingMesh& mesh, const mesh::TriangleTree& tree,
                             const std::vector<Index>& faces, double tolerance) {
    std::vector<std::uint8_t> is_far(faces.size());
    parallel_for(0, static_cast<std::int64_t>(faces.size()), kGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                     Index near = 0;
                     for (auto k = static_cast<std::size_t>(begin);
                          k < static_cast<std::size_t>(end); ++k)
                         is_far[k] = distance_of(mesh, tree, faces[k], tolerance, near) > tolerance;
                 });
    std::vector<Index> far;
    for (std::size_t k = 0; k < faces.size(); ++k)
        if (is_far[k]) far.push_back(faces[k]);
    return far;
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
        const double least = std::min(kLeastFit, mesh.worst_fit(v));
        mesh.put(v, place);
        const double fit = mesh.worst_fit(v);
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

void draw_near(MovingMesh& mesh, const mesh::TriangleTree& tree, double tolerance) {
    std::vector<Index> faces(mesh.face_count());
    std::iota(faces.begin(), faces.end(), Index{0});
    Index closest = 0;
    for (int round = 0; round < kNearRounds; ++round) {
        const std::vector<Index> near = mesh.around(far_faces(mesh, tree, faces, tolerance));
        faces.clear();
        for (const Index v : near) {
            if (mesh.fixed[v]) continue;
            const double least = std::min(kLeastFit, mesh.worst_fit(v));
            const bool better = try_places(mesh, v, [&] {
                if (mesh.worst_fit(v) < least) return -HUGE_VAL;
                double most = 0;
                for (const Index c : mesh.corners_at(v))
                    most = std::max(most, distance_of(mesh, tree, c / 3, tolerance, closest));
                return -most;
            });
            for (const Index c : mesh.corners_at(v))
                if (better) faces.push_back(c / 3);
        }
        std::sort(faces.begin(), faces.end());
        faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    }
}

}  // namespace relief::remesh
