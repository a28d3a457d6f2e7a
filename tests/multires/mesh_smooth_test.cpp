#include "relief/multires/mesh_smooth.h"

#include <gtest/gtest.h>

#include "multires/mesh_support.h"
#include "relief/multires/mesh_hierarchy.h"

namespace relief::multires {
namespace {

using mesh::Index;
using mesh::Split;
using test::all_levels;
using test::distance;
using test::Level;
using test::noisy;
using test::Points;

/// Off the mean of the neighbours, of vertices that are on no curve.
Points umbrellas(const Level& level, const Points& c) {
    Points sums(c.size());
    std::vector<double> count(c.size(), 0);
    for (Index h = 0; h < level.coarse.half_edge_count(); ++h) {
        sums[level.coarse.origin[h]] += c[level.coarse.target(h)];
        ++count[level.coarse.origin[h]];
    }
    Points result(c.size());
    for (std::size_t v = 0; v < c.size(); ++v)
        if (level.rules.kinds[v] <= VertexKind::Dart) result[v] = c[v] - 1 / count[v] * sums[v];
    return result;
}

double squares(const Points& points) {
    double sum = 0;
    for (const auto& p : points) sum += dot(p, p);
    return sum;
}

double energy(const Level& level, double omega, const Points& c, const Points& g) {
    Points off = level.subdivided(c);
    for (std::size_t k = 0; k < g.size(); ++k) off[k] -= g[k];
    return omega * squares(off) + (1 - omega) * squares(umbrellas(level, c));
}

/// The reversal of g by least squares, curves by themselves.
Points reversed(const Level& level, const Points& g) {
    const MeshStep<double> step = level.step();
    const auto [fine, residuals] = level.analysed(g);
    Points c(fine.begin(), fine.begin() + static_cast<long>(step.coarse_count()));
    Points delta(c.size());
    MeshLift::create(step, {.kind = LiftKind::LeastSquares})
        ->apply(fine.data() + c.size(), residuals.data(), delta.data());
    for (std::size_t v = 0; v < c.size(); ++v) c[v] += delta[v];
    return c;
}

/// Nothing nearby has less energy: a square in the distance has no slope.
TEST(MeshSmoothing, IsTheLeast) {
    for (const auto& [name, level] : all_levels()) {
        const std::size_t coarse = level.coarse.vertex_count;
        const Points g = noisy(level.subdivided(noisy(Points(coarse), 5, 1)), 9, 0.1);
        for (const double omega : {0.9, 0.3}) {
            Points c = reversed(level, g);
            const MeshStep<double> step = level.step();
            MeshSmoothing::create(step, omega)->smooth(c.data());
            const double least = energy(level, omega, c, g);
            const Points way = noisy(Points(coarse), 11, 1);
            const auto moved = [&](double by) {
                Points x = c;
                for (std::size_t v = 0; v < coarse; ++v)
                    if (level.rules.kinds[v] <= VertexKind::Dart) x[v] += by * way[v];
                return energy(level, omega, x, g) - least;
            };
            // Central differences of a quadratic are exact: rounding alone.
            EXPECT_NEAR(moved(0.01) - moved(-0.01), 0, 1e-9 * (1 + least)) << name;
            EXPECT_GE(moved(0.01) + moved(-0.01), 0) << name;
        }
    }
}

TEST(MeshSmoothing, IsUndone) {
    for (const auto& [name, level] : all_levels()) {
        const Points c = noisy(Points(level.coarse.vertex_count), 5, 1);
        for (const double omega : {1.0, 0.5, 0.1}) {
            const MeshStep<double> step = level.step();
            const MeshSmoothing smoothing = *MeshSmoothing::create(step, omega);
            Points x = c;
            smoothing.smooth(x.data());
            for (std::size_t v = 0; v < c.size(); ++v)
                if (level.rules.kinds[v] >= VertexKind::Crease) {
                    ASSERT_EQ(x[v], c[v]) << name;
                }
            smoothing.restore(x.data());
            // P^T P has a condition of at most some hundreds, and 1/omega.
            EXPECT_LT(distance(x, c), 1e-11) << name;
        }
    }
}

/// Multiresolution with smoothing gives the mesh again.
TEST(MeshSmoothing, RoundTrips) {
    const test::Shape shapes[] = {test::cube(), test::double_torus(), test::grid(4, 3, false)};
    for (const test::Shape& shape : shapes)
        for (const MeshScheme scheme :
             {MeshScheme::Sqrt3, MeshScheme::Loop, MeshScheme::CatmullClark}) {
            const test::Shape base =
                scheme == MeshScheme::CatmullClark ? shape : test::triangulated(shape);
            mesh::Topology mesh = base.topology();
            const MeshTags tags = scheme == MeshScheme::Sqrt3 || shape.size() == 8
                                      ? MeshTags()
                                      : test::some_tags(mesh, 7);
            const MeshHierarchy hierarchy =
                *MeshHierarchy::create(std::move(mesh), tags, {.scheme = scheme}, 2);
            const Points g = noisy(Points(hierarchy.vertices(2)), 2, 1);
            for (const double omega : {0.7, 0.3})
                for (const bool local : {false, true}) {
                    const MeshTransform transform{
                        .lift = LiftKind::LeastSquares, .local_frames = local, .omega = omega};
                    const MeshMaps maps = *MeshMaps::create(hierarchy, transform);
                    Points points = g;
                    StiffResiduals residuals;
                    maps.analyse(points.data(), residuals);
                    maps.synthesise(0, 2, points.data(), residuals);
                    EXPECT_LT(distance(points, g), 1e-11) << mesh_scheme_name(scheme);
                }
        }
}

/// Less of omega is farther and smoother, as the measurements of section 7.5 say.
TEST(MeshSmoothing, TradesNearnessForSmoothness) {
    const Level level(test::flipped(test::grid(16, 8, true, true), 30, 1).topology(), {},
                      Split::Sqrt3Odd);
    const Points shape = test::points_of(test::grid(16, 8, true, true));
    const Points g = noisy(level.subdivided(shape), 3, 0.01);
    const Points nearest = reversed(level, g);
    const double best = std::sqrt(energy(level, 1, nearest, g));
    double last = std::sqrt(squares(umbrellas(level, nearest)));
    double last_ratio = 1;
    for (const double omega : {0.9, 0.7, 0.5, 0.3}) {
        Points c = nearest;
        const MeshStep<double> step = level.step();
        MeshSmoothing::create(step, omega)->smooth(c.data());
        const double ratio = std::sqrt(energy(level, 1, c, g)) / best;
        const double rough = std::sqrt(squares(umbrellas(level, c)));
        EXPECT_GT(ratio, last_ratio);
        EXPECT_LT(rough, last);
        last = rough;
        last_ratio = ratio;
    }
}

TEST(MeshSmoothing, Refusals) {
    const Level level(test::octahedron().topology(), {}, Split::Loop);
    const MeshStep<double> step = level.step();
    for (const double omega : {0.0, -0.5, 1.5, double{NAN}, double{INFINITY}}) {
        const auto made = MeshSmoothing::create(step, omega);
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().message.rfind("invalid_parameter: ", 0), 0U);
        const auto hierarchy = *MeshHierarchy::create(test::octahedron().topology(), {}, {}, 1);
        EXPECT_FALSE(MeshMaps::create(hierarchy, {.omega = omega}).ok());
    }
    EXPECT_TRUE(MeshSmoothing::create(step, 1).ok());
}

}  // namespace
}  // namespace relief::multires
