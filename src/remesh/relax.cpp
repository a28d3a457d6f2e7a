#include "remesh/relax.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "relief/core/parallel.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using Point = Vec3<double>;

constexpr std::int64_t kGrain = 512;
constexpr double kStep = 0.8;
constexpr int kSmoothings = 4;
constexpr double kLeastCurvature = 0.3;
constexpr double kMostCurvature = 20;
/// Errors are measured every so many rounds, if there are so many.
constexpr int kMeasureEvery = 5;
constexpr int kLong = 10;
constexpr double kErrorWeight = 4;
constexpr double kMostWeight = 1e4;

/// Halfway to the mean over the ends of edges.
std::vector<double> smoothed(const mesh::Topology& mesh, const std::vector<double>& values) {
    std::vector<double> sums(values.size(), 0);
    std::vector<double> counts(values.size(), 0);
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        if (!mesh.is_first(h)) continue;
        const Index a = mesh.origin[h];
        const Index b = mesh.target(h);
        sums[a] += values[b];
        sums[b] += values[a];
        ++counts[a];
        ++counts[b];
    }
    for (std::size_t v = 0; v < values.size(); ++v)
        sums[v] = 0.5 * values[v] + 0.5 * sums[v] / counts[v];
    return sums;
}

/// The weights that errors give to vertices.
class ErrorWeights {
  public:
    ErrorWeights(const MovingMesh& mesh, const mesh::TriangleTree& tree)
        : mesh_(mesh), tree_(tree), weights_(mesh.points.size(), 1) {}

    [[nodiscard]] double operator[](Index v) const { return weights_[v]; }

    void measure() {
        std::vector<double> errors = errors_at_vertices(mesh_, tree_);
        double area = 0;
        for (Index f = 0; f < mesh_.face_count(); ++f) {
            const Index* v = mesh_.corners.data() + 3 * f;
            area += length(cross(mesh_.points[v[1]] - mesh_.points[v[0]],
                                 mesh_.points[v[2]] - mesh_.points[v[0]]));
        }
        const double edge = std::sqrt(area / static_cast<double>(mesh_.face_count()));
        for (int k = 0; k < 3; ++k) spread(errors);
        for (std::size_t v = 0; v < weights_.size(); ++v)
            weights_[v] =
                std::clamp(weights_[v] * (1 + kErrorWeight * errors[v] / edge), 1.0, kMostWeight);
    }

  private:
    void spread(std::vector<double>& errors) const {
        std::vector<double> sums(errors.size(), 0);
        for (Index f = 0; f < mesh_.face_count(); ++f) {
            const Index* v = mesh_.corners.data() + 3 * f;
            const double sum = errors[v[0]] + errors[v[1]] + errors[v[2]];
            for (Index k = 0; k < 3; ++k) sums[v[k]] += (sum - errors[v[k]]) / 2;
        }
        for (Index v = 0; v < errors.size(); ++v) {
            const double mean = sums[v] / static_cast<double>(mesh_.corners_at(v).size());
            errors[v] = std::max(0.7 * errors[v], 0.5 * errors[v] + 0.5 * mean);
        }
    }

    const MovingMesh& mesh_;
    const mesh::TriangleTree& tree_;
    std::vector<double> weights_;
};

}  // namespace

std::vector<double> relative_curvature(const Surface& surface) {
    const mesh::Topology& mesh = surface.mesh;
    std::vector<double> curvature(mesh.vertex_count, 0);
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        if (!mesh.is_first(h)) continue;
        const Index a = mesh.origin[h];
        const Index b = mesh.target(h);
        const double edge = length(surface.points[b] - surface.points[a]);
        if (!(edge > 0)) continue;
        const double turn = length(surface.normals[b] - surface.normals[a]) / edge;
        curvature[a] = std::max(curvature[a], turn);
        curvature[b] = std::max(curvature[b], turn);
    }
    for (int k = 0; k < kSmoothings; ++k) curvature = smoothed(mesh, curvature);
    std::vector<double> sorted = curvature;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double median = *middle;
    for (double& k : curvature)
        k = median > 0 ? std::clamp(k / median, kLeastCurvature, kMostCurvature) : 1;
    return curvature;
}

Reverse distances_from(const MovingMesh& mesh) {
    const mesh::TriangleTree tree(mesh.triangles());
    const std::vector<Point>& points = mesh.surface->points;
    Reverse reverse{std::vector<double>(points.size()), std::vector<Index>(points.size())};
    parallel_for(0, static_cast<std::int64_t>(points.size()), kGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                     Index near = 0;
                     for (auto v = static_cast<std::size_t>(begin);
                          v < static_cast<std::size_t>(end); ++v) {
                         const mesh::SurfacePoint closest = tree.closest_from(near, points[v]);
                         near = closest.triangle;
                         reverse.distances[v] = closest.distance;
                         reverse.faces[v] = closest.face;
                     }
                 });
    return reverse;
}

std::vector<double> errors_at_vertices(const MovingMesh& mesh, const mesh::TriangleTree& tree) {
    std::vector<double> of_face(mesh.face_count());
    parallel_for(0, static_cast<std::int64_t>(of_face.size()), kGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                     Index near = 0;
                     for (auto f = static_cast<Index>(begin); f < end; ++f) {
                         const Index* v = mesh.corners.data() + 3 * f;
                         const Point centre =
                             1.0 / 3 * (mesh.points[v[0]] + mesh.points[v[1]] + mesh.points[v[2]]);
                         const mesh::SurfacePoint closest = tree.closest_from(near, centre);
                         near = closest.triangle;
                         of_face[f] = closest.distance;
                     }
                 });
    const Reverse reverse = distances_from(mesh);
    for (std::size_t v = 0; v < reverse.faces.size(); ++v)
        of_face[reverse.faces[v]] = std::max(of_face[reverse.faces[v]], reverse.distances[v]);
    std::vector<double> errors(mesh.points.size(), 0);
    for (Index c = 0; c < mesh.corners.size(); ++c)
        errors[mesh.corners[c]] = std::max(errors[mesh.corners[c]], of_face[c / 3]);
    return errors;
}

void relax(MovingMesh& mesh, const std::vector<double>& curvature, const mesh::TriangleTree& tree,
           int rounds) {
    ErrorWeights errors(mesh, tree);
    std::vector<double> densities(mesh.points.size());
    std::vector<Point> centres(mesh.face_count());
    std::vector<double> weights(mesh.face_count());
    std::vector<Point> steps(mesh.points.size());
    const auto in_blocks = [](std::size_t count, auto&& visit) {
        parallel_for(0, static_cast<std::int64_t>(count), kGrain,
                     [&](std::int64_t begin, std::int64_t end) {
                         for (auto k = static_cast<Index>(begin); k < end; ++k) visit(k);
                     });
    };
    for (int round = 0; round < rounds; ++round) {
        const bool last = round + 3 >= rounds;
        if (rounds >= kLong && round % kMeasureEvery == 0 && !last) errors.measure();
        in_blocks(densities.size(), [&](Index v) {
            const Place& place = mesh.places[v];
            const Index* corner = mesh.surface->mesh.origin.data() + 3 * place.face;
            double kappa = 0;
            for (std::size_t k = 0; k < 3; ++k) kappa += place.weights[k] * curvature[corner[k]];
            densities[v] = kappa * std::sqrt(std::sqrt(errors[v]));
        });
        in_blocks(centres.size(), [&](Index f) {
            const Index* v = mesh.corners.data() + 3 * f;
            const auto& [a, b, c] =
                std::array{mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]]};
            const double density = (densities[v[0]] + densities[v[1]] + densities[v[2]]) / 3;
            centres[f] = 1.0 / 3 * (a + b + c);
            weights[f] = length(cross(b - a, c - a)) * density * density;
        });
        in_blocks(steps.size(), [&](Index v) {
            Point centre;
            double sum = 0;
            for (const Index c : mesh.corners_at(v)) {
                centre += weights[c / 3] * centres[c / 3];
                sum += weights[c / 3];
            }
            steps[v] = sum > 0 ? kStep * (1 / sum * centre - mesh.points[v]) : Point{};
        });
        mesh.move(steps);
    }
}

}  // namespace relief::remesh
