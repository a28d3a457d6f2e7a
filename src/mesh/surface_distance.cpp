#include <algorithm>
#include <cmath>

#include "relief/core/parallel.h"
#include "relief/mesh/closest.h"

namespace relief::mesh {

namespace {

using Point = Vec3<double>;

constexpr std::int64_t kGrain = 256;

/// Points spread evenly over the area of triangles: equal steps of area along a list of
/// triangles, and within these the sequence of Roberts (2018) that continues the golden ratio to
/// the plane.
class AreaSamples {
  public:
    AreaSamples(const std::vector<FanTriangle>& triangles, std::int64_t count)
        : triangles_(triangles), count_(count), until_(triangles.size()) {
        double sum = 0;
        for (std::size_t k = 0; k < triangles.size(); ++k) {
            const auto& t = triangles[k].corners;
            sum += length(cross(t[1] - t[0], t[2] - t[0]));
            until_[k] = sum;
        }
        if (sum > 0 && std::isfinite(sum)) return;
        for (std::size_t k = 0; k < until_.size(); ++k) until_[k] = static_cast<double>(k + 1);
    }

    [[nodiscard]] Point operator[](std::int64_t k) const {
        const double area =
            (static_cast<double>(k) + 0.5) / static_cast<double>(count_) * until_.back();
        const auto found = std::upper_bound(until_.begin(), until_.end() - 1, area);
        const auto& t = triangles_[static_cast<std::size_t>(found - until_.begin())].corners;
        double u = multiple(k, 0xC13FA9A902A6328F);
        double v = multiple(k, 0x91E10DA5C79E7B1C);
        if (u + v > 1) {  // the other half of the parallelogram
            u = 1 - u;
            v = 1 - v;
        }
        return t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
    }

  private:
    /// The fraction of (k + 1/2) times a fraction of 2^-64.
    static double multiple(std::int64_t k, std::uint64_t fraction) {
        const std::uint64_t product = static_cast<std::uint64_t>(k) * fraction + (fraction >> 1);
        return static_cast<double>(product >> 11) * 0x1p-53;
    }

    const std::vector<FanTriangle>& triangles_;
    std::int64_t count_;
    std::vector<double> until_;  ///< sum of the areas up to each triangle
};

/// What is known of some points of a surface.
struct Measured {
    double squares = 0;
    double largest = -1;
    Point farthest;
};

/// Measures point(0) .. point(count - 1), blocks of them in parallel; distances up to `enough` may
/// be taken for smaller ones.
template <class PointOf>
Measured measured(std::int64_t count, const TriangleTree& surface, double enough, PointOf point) {
    std::vector<Measured> blocks(static_cast<std::size_t>((count + kGrain - 1) / kGrain));
    parallel_for(0, count, kGrain, [&](std::int64_t first, std::int64_t end) {
        Measured block;
        Index near = 0;
        for (std::int64_t k = first; k < end; ++k) {
            const Point p = point(k);
            const SurfacePoint closest = surface.closest_from(near, p, enough);
            near = closest.triangle;
            const double distance = closest.distance;
            block.squares += distance * distance;
            if (distance > block.largest) block = {block.squares, distance, p};
        }
        blocks[static_cast<std::size_t>(first / kGrain)] = block;
    });
    Measured all;
    for (const Measured& block : blocks) {
        const double squares = all.squares + block.squares;
        if (block.largest > all.largest) all = block;
        all.squares = squares;
    }
    return all;
}

std::vector<Point> used_vertices(const PolygonMesh& mesh) {
    std::vector<bool> used(mesh.vertices.size(), false);
    for (const std::int32_t v : mesh.corners) used[static_cast<std::size_t>(v)] = true;
    std::vector<Point> points;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v])
            points.push_back({mesh.vertices[v][0], mesh.vertices[v][1], mesh.vertices[v][2]});
    return points;
}

DirectedDistance directed(const PolygonMesh& mesh, const TriangleTree& surface,
                          std::int64_t samples) {
    const std::vector<FanTriangle> triangles = fan_triangles(mesh);
    const AreaSamples sample(triangles, samples);
    const Measured even = measured(samples, surface, 0, [&](std::int64_t k) { return sample[k]; });
    const std::vector<Point> vertices = used_vertices(mesh);
    const Measured corners =
        measured(static_cast<std::int64_t>(vertices.size()), surface, even.largest,
                 [&](std::int64_t k) { return vertices[static_cast<std::size_t>(k)]; });
    const Measured& worst = corners.largest > even.largest ? corners : even;
    return {worst.largest, std::sqrt(even.squares / static_cast<double>(samples)), worst.farthest};
}

}  // namespace

double SurfaceDistance::largest() const {
    return std::max(a_to_b.largest, b_to_a.largest);
}

double SurfaceDistance::rms() const {
    return std::max(a_to_b.rms, b_to_a.rms);
}

Result<SurfaceDistance> surface_distance(const PolygonMesh& a, const PolygonMesh& b,
                                         std::int64_t samples) {
    return surface_distance(a, TriangleTree(fan_triangles(a)), b, samples);
}

Result<SurfaceDistance> surface_distance(const PolygonMesh& a, const TriangleTree& tree_of_a,
                                         const PolygonMesh& b, std::int64_t samples) {
    for (const PolygonMesh* mesh : {&a, &b})
        if (mesh->polygon_count() == 0)
            return Error{ErrorCode::BadInput, "empty_mesh: it has no polygon to measure",
                         mesh == &a ? "the first mesh" : "the second mesh"};
    const TriangleTree tree_of_b(fan_triangles(b));
    return SurfaceDistance{directed(a, tree_of_b, samples), directed(b, tree_of_a, samples)};
}

std::vector<double> vertex_distances(const PolygonMesh& mesh, const TriangleTree& surface) {
    std::vector<double> distances(mesh.vertices.size());
    parallel_for(
        0, static_cast<std::int64_t>(distances.size()), kGrain,
        [&](std::int64_t first, std::int64_t end) {
            Index near = 0;
            for (auto v = static_cast<std::size_t>(first); v < static_cast<std::size_t>(end); ++v) {
                const auto& p = mesh.vertices[v];
                const SurfacePoint closest = surface.closest_from(near, {p[0], p[1], p[2]});
                near = closest.triangle;
                distances[v] = closest.distance;
            }
        });
    return distances;
}

}  // namespace relief::mesh
