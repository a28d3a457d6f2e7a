#include "relief/multires/ps_interpolant.h"

#include <algorithm>
#include <cmath>

#include "multires/ps_errors.h"

namespace relief::multires::ps {

using mesh::Index;

namespace {

constexpr double kLargest = 1e150;

Status check(std::span<const Vec2> points, std::span<const double> values) {
    if (values.size() != points.size())
        return bad_input("size_mismatch: " + std::to_string(values.size()) + " values for " +
                         std::to_string(points.size()) + " points");
    const auto bad = std::find_if(values.begin(), values.end(),
                                  [](double z) { return !(std::abs(z) <= kLargest); });
    if (bad == values.end()) return {};
    return bad_input(
        "non_finite_data: its value is not a number of at most 1e150; leave the point "
        "out or correct it",
        "point " + std::to_string(bad - values.begin()));
}

Result<TangentPlanes> planes_of(const mesh::Triangulation& mesh, std::span<const double> values,
                                const GradientOptions& options) {
    RELIEF_TRY(const std::vector<Vec2> gradients, estimate_gradients(mesh, values, options));
    TangentPlanes planes(values.size());
    for_each_index(planes.size(), [&](Index v) { planes[v] = {values[v], gradients[v]}; });
    return planes;
}

}  // namespace

std::vector<double> vertex_means(std::size_t vertex_count, std::span<const Index> vertex_of_point,
                                 std::span<const double> values, std::span<const double> weights) {
    struct Sum {
        double values = 0;
        double count = 0;
        double weighted = 0;
        double weights = 0;
    };
    std::vector<Sum> sums(vertex_count);
    for (std::size_t k = 0; k < values.size(); ++k) {
        Sum& sum = sums[vertex_of_point[k]];
        const double weight = weights.empty() ? 1 : weights[k];
        sum.values += values[k];
        sum.count += 1;
        sum.weighted += weight * values[k];
        sum.weights += weight;
    }
    std::vector<double> means(vertex_count);
    std::transform(sums.begin(), sums.end(), means.begin(), [](const Sum& sum) {
        return sum.weights > 0 ? sum.weighted / sum.weights : sum.values / sum.count;
    });
    return means;
}

Result<Interpolant> Interpolant::create(std::span<const Vec2> points,
                                        std::span<const double> values,
                                        const InterpolationOptions& options) {
    RELIEF_CHECK(check(points, values));
    RELIEF_TRY(mesh::Delaunay delaunay, mesh::delaunay(points, options.delaunay));
    mesh::Triangulation mesh = std::move(delaunay.mesh);
    RELIEF_TRY(const TangentPlanes planes,
               planes_of(mesh, vertex_means(mesh.vertex_count(), delaunay.vertex_of_point, values),
                         options.gradients));
    RELIEF_TRY(const Split cut, split(mesh));
    RELIEF_TRY(Surface surface, Surface::create(mesh, cut, std::span(&planes, 1)));
    const std::vector<mesh::TriangleSide> boundary = mesh::boundary_sides(mesh);
    auto triangles = std::make_unique<const mesh::PlaneTriangles>(std::move(mesh));
    surface.follow(*triangles);
    mesh::TriangleLocator locator(*triangles, boundary);
    return Interpolant(std::move(triangles), std::move(surface), std::move(locator));
}

}  // namespace relief::multires::ps
