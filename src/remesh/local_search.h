#pragma once

#include <array>
#include <cmath>

#include "remesh/moving_mesh.h"

namespace relief::remesh {

/// Puts one vertex of a mesh to that of some places around it for which score() is the largest; it
/// is asked with the vertex there. The places are on the way to the mean of its neighbours and in
/// eight directions, near and far. False: it is best where it is.
template <class Score>
bool try_places(MovingMesh& mesh, mesh::Index v, const Score& score) {
    using Point = Vec3<double>;
    // In the plane of the face there, and in mean edges.
    constexpr std::array<std::array<double, 2>, 8> kDirections = {
        {{1, 0}, {0.7, 0.7}, {0, 1}, {-0.7, 0.7}, {-1, 0}, {-0.7, -0.7}, {0, -1}, {0.7, -0.7}}};
    constexpr std::array<double, 4> kLengths = {0.6, 0.25, 0.1, 0.03};
    constexpr std::array<double, 3> kTowardsMean = {1, 0.5, 0.2};
    const Place from = mesh.places[v];
    const Point here = mesh.points[v];
    Place best = from;
    double most = score();
    bool better = false;
    const auto attempt = [&](const Point& step) {
        const Place place = walk(*mesh.surface, from, step);
        mesh.put(v, place);
        const double reached = score();
        if (reached <= most) return;
        most = reached;
        best = place;
        better = true;
    };
    Point mean;
    double edge = 0;
    for (const mesh::Index c : mesh.corners_at(v))
        for (const mesh::Index k : {1U, 2U}) {
            const Point& p = mesh.points[mesh.corners[c / 3 * 3 + (c % 3 + k) % 3]];
            mean += p;
            edge += length(p - here);
        }
    const double count = 2 * static_cast<double>(mesh.corners_at(v).size());
    mean = 1 / count * mean;
    edge /= count;
    for (const double share : kTowardsMean) attempt(share * (mean - here));
    const Point& normal = mesh.surface->face_normals[from.face];
    const Point axis = std::abs(normal.x) < 0.6 ? Point{1, 0, 0} : Point{0, 1, 0};
    const Point u = cross(axis, normal);
    const Point w = cross(normal, u);
    for (const double size : kLengths)
        for (const auto& [x, y] : kDirections) attempt(size * edge * (x * u + y * w));
    mesh.put(v, best);
    return better;
}

}  // namespace relief::remesh
