#include "remesh/fit.h"

#include <algorithm>
#include <array>

#include "relief/core/parallel.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using Point = Vec3<double>;
using Weights = std::array<double, 3>;

constexpr std::int64_t kGrain = 256;
/// Samples of a face: the centroids of the four triangles between the midpoints of its sides.
constexpr std::array<Weights, 4> kSamples = {{{2.0 / 3, 1.0 / 6, 1.0 / 6},
                                              {1.0 / 6, 2.0 / 3, 1.0 / 6},
                                              {1.0 / 6, 1.0 / 6, 2.0 / 3},
                                              {1.0 / 3, 1.0 / 3, 1.0 / 3}}};
/// A sample counts if the surface beside it runs about as the face does: the cosine.
constexpr double kLeastTurn = 0.5;

Point unit(const Point& a) {
    const double size = length(a);
    return size > 0 ? 1 / size * a : Point{};
}

/// What the samples of a face say: for each corner the sum of weights, and of weights times the
/// distance along the normal.
struct FaceSums {
    Weights weights{};
    Weights distances{};
};

/// near: a triangle of the tree where to begin, and the one that was closest last.
FaceSums sums_of(const MovingMesh& mesh, const mesh::TriangleTree& surface, Index f, Index& near) {
    FaceSums sums;
    const Index* v = mesh.corners.data() + 3 * f;
    const std::array<Point, 3> p = {mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]]};
    const Point doubled = cross(p[1] - p[0], p[2] - p[0]);
    const double area = length(doubled);
    const Point normal = unit(doubled);
    for (const Weights& w : kSamples) {
        const Point sample = w[0] * p[0] + w[1] * p[1] + w[2] * p[2];
        const mesh::SurfacePoint closest = surface.closest_from(near, sample);
        near = closest.triangle;
        if (dot(mesh.surface->face_normals[closest.face], normal) < kLeastTurn) continue;
        const double distance = dot(closest.point - sample, normal);
        for (std::size_t k = 0; k < 3; ++k) {
            sums.weights[k] += area * w[k];
            sums.distances[k] += area * w[k] * distance;
        }
    }
    return sums;
}

/// Vertices of flipped faces go back to the surface, where no face need be flipped.
void return_flipped(MovingMesh& mesh) {
    std::vector<Index> wrong = mesh.flips();
    while (!wrong.empty()) {
        const Index f = wrong.back();
        wrong.pop_back();
        if (!mesh.flipped(f)) continue;
        for (Index k = 0; k < 3; ++k) {
            const Index v = mesh.corners[3 * f + k];
            if (mesh.points[v] == mesh.surface->point(mesh.places[v])) continue;
            mesh.put(v, mesh.places[v]);
            for (const Index c : mesh.corners_at(v)) wrong.push_back(c / 3);
        }
    }
}

}  // namespace

void fit(MovingMesh& mesh, const mesh::TriangleTree& surface, int rounds) {
    std::vector<FaceSums> sums(mesh.face_count());
    for (int round = 0; round < rounds; ++round) {
        parallel_for(0, static_cast<std::int64_t>(sums.size()), kGrain,
                     [&](std::int64_t begin, std::int64_t end) {
                         Index near = 0;
                         for (auto f = static_cast<Index>(begin); f < end; ++f)
                             sums[f] = sums_of(mesh, surface, f, near);
                     });
        for (Index v = 0; v < mesh.points.size(); ++v) {
            if (mesh.fixed[v]) continue;
            double weight = 0;
            double distance = 0;
            for (const Index c : mesh.corners_at(v)) {
                weight += sums[c / 3].weights[c % 3];
                distance += sums[c / 3].distances[c % 3];
            }
            if (weight > 0) mesh.points[v] += distance / weight * unit(mesh.normals[v]);
        }
    }
    return_flipped(mesh);
}

}  // namespace relief::remesh
