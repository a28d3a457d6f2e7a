#include "relief/multires/mesh_lift.h"

#include <gtest/gtest.h>

#include "multires/mesh_support.h"

namespace relief::multires {
namespace {

using mesh::Index;
using mesh::Split;
using test::all_levels;
using test::distance;
using test::Level;
using test::noisy;
using test::Points;
using test::points_of;

/// Lifted coarse vertices of fine ones.
Points lifted(const Level& level, const Points& g, const LiftOptions& options) {
    const auto [fine, residuals] = level.analysed(g);
    const MeshStep<double> step = level.step();
    const MeshLift lift = *MeshLift::create(step, options);
    Points c(fine.begin(), fine.begin() + static_cast<long>(step.coarse_count()));
    Points delta(c.size());
    lift.apply(fine.data() + c.size(), residuals.data(), delta.data());
    for (std::size_t v = 0; v < c.size(); ++v) c[v] += delta[v];
    return c;
}

double residual(const Level& level, const Points& c, const Points& g) {
    const Points fine = level.subdivided(c);
    double sum = 0;
    for (std::size_t k = 0; k < g.size(); ++k) sum += dot(g[k] - fine[k], g[k] - fine[k]);
    return std::sqrt(sum);
}

TEST(MeshLift, ReferenceVectors) {
    const auto golden = test::reference("reverse_subdivision.json");
    for (const auto& record : golden["decompositions"]) {
        if (!record.contains("cheb")) continue;
        const Level level = test::level_of(record);
        const Points g = points_of(record["g"]);
        const auto& cheb = record["cheb"];
        const Points swept = lifted(level, g, {LiftKind::Chebyshev, cheb["k"], cheb["lo"]});
        EXPECT_LT(distance(swept, points_of(cheb["c"])),
                  10 * golden["tolerances"]["cheb"].get<double>())
            << record["name"];
        const Points best = lifted(level, g, {.kind = LiftKind::LeastSquares});
        EXPECT_LT(distance(best, points_of(record["least_squares"]["c"])),
                  10 * golden["tolerances"]["least_squares"].get<double>())
            << record["name"];
        EXPECT_NEAR(residual(level, best, g),
                    record["least_squares"]["residual_norm"].get<double>(), 1e-10)
            << record["name"];
    }
}

/// The source paper's closed forms, 7.1.
TEST(MeshLift, RingCoefficients) {
    const auto coefficient = [](const test::Shape& shape, Split split, Index vertex, bool face) {
        const Level level(shape.topology(), {}, split);
        const MeshStep<double> step = level.step();
        const MeshLift lift = *MeshLift::create(step, {.kind = LiftKind::Ring});
        Points details(step.new_count());
        // A detail at one new vertex of the star.
        const auto out = mesh::outgoing(level.coarse);
        const Index h = out[vertex];
        const Index f = level.coarse.face_of(h);
        const Index point = split == Split::Sqrt3Odd ? f
                            : face                   ? level.coarse.edge_count + f
                                                     : level.coarse.edge[h];
        details[point] = {1, 0, 0};
        Points delta(step.coarse_count());
        lift.apply(details.data(), nullptr, delta.data());
        return delta[vertex].x;
    };
    EXPECT_NEAR(coefficient(test::icosahedron(), Split::Sqrt3Odd, 0, false), 0.427103, 5e-7);
    EXPECT_NEAR(coefficient(test::octahedron(), Split::Sqrt3Odd, 0, false), 0.565574, 5e-7);
    EXPECT_NEAR(coefficient(test::octahedron(), Split::Loop, 0, false), 0.573298, 5e-7);
    EXPECT_NEAR(coefficient(test::icosahedron(), Split::Loop, 0, false), 0.435979, 5e-7);
    const test::Shape torus = test::grid(5, 5, false, true);
    EXPECT_NEAR(coefficient(torus, Split::CatmullClark, 7, false), 0.456747, 5e-7);
    EXPECT_NEAR(coefficient(torus, Split::CatmullClark, 7, true), 0.190311, 5e-7);
}

/// Without curves the least squares solution is orthogonal to all of P; with curves to the inner
/// columns.
TEST(MeshLift, LeastSquaresIsOrthogonal) {
    for (const auto& [name, level] : all_levels()) {
        const Points g = noisy(Points(level.coarse.vertex_count + level.rules.new_count), 4, 1);
        const Points c = lifted(level, g, {.kind = LiftKind::LeastSquares});
        Points e = level.subdivided(c);
        for (std::size_t k = 0; k < g.size(); ++k) e[k] = g[k] - e[k];
        Points image(c.size());
        level.step().adjoint(e.data(), e.data() + c.size(), image.data());
        for (std::size_t v = 0; v < c.size(); ++v)
            if (level.rules.kinds[v] <= VertexKind::Dart) {
                ASSERT_LT(length(image[v]), 1e-10) << name << " vertex " << v;
            }
    }
}

TEST(MeshLift, SweepsComeNear) {
    for (const auto& [name, level] : all_levels()) {
        const Points g = noisy(Points(level.coarse.vertex_count + level.rules.new_count), 9, 1);
        const MeshScheme scheme = level.rules.split == Split::Loop ? MeshScheme::Loop
                                  : level.rules.split == Split::CatmullClark
                                      ? MeshScheme::CatmullClark
                                      : MeshScheme::Sqrt3;
        const double best = residual(level, lifted(level, g, {.kind = LiftKind::LeastSquares}), g);
        const double swept = residual(level, lifted(level, g, default_lift(scheme, 1)), g);
        const double plain = residual(level, lifted(level, g, {.kind = LiftKind::None}), g);
        EXPECT_LT(swept, 1.03 * best) << name;
        EXPECT_LT(swept, plain) << name;
    }
}

/// Reversed curves depend on nothing beside them.
TEST(MeshLift, BoundariesAreTheirOwn) {
    const auto open = test::flipped(test::grid(5, 4, true), 20, 2);
    for (const Split split : {Split::Loop, Split::CatmullClark, Split::Sqrt3Odd}) {
        mesh::Topology mesh = open.topology();
        Split used = split;
        if (split == Split::Sqrt3Odd) {
            mesh = *mesh::refine(mesh, Split::Sqrt3Odd);
            used = Split::Sqrt3Even;
        }
        const Level level(std::move(mesh), {}, used);
        const mesh::Topology fine = *mesh::refine(level.coarse, used);
        Points g = noisy(Points(fine.vertex_count), 1, 1);
        const Points before = lifted(level, g, {LiftKind::Chebyshev, 6, 0.125});
        const auto out = mesh::outgoing(fine);
        for (Index v = 0; v < fine.vertex_count; ++v)
            if (!fine.on_boundary(out[v])) g[v] = g[v] + Vec3<double>{1, v * 0.1, -2};
        const Points after = lifted(level, g, {LiftKind::Chebyshev, 6, 0.125});
        for (Index v = 0; v < level.coarse.vertex_count; ++v)
            if (level.rules.kinds[v] >= VertexKind::Crease) {
                ASSERT_EQ(before[v], after[v]) << v;
            }
    }
}

TEST(MeshLift, Refusals) {
    const Level level(test::octahedron().topology(), {}, Split::Loop);
    const MeshStep<double> step = level.step();
    for (const LiftOptions& bad :
         {LiftOptions{LiftKind::Chebyshev, 0, 0.1}, LiftOptions{LiftKind::Chebyshev, 3, 0},
          LiftOptions{LiftKind::Chebyshev, 3, 1}, LiftOptions{LiftKind::Chebyshev, 3, NAN}})
        EXPECT_FALSE(MeshLift::create(step, bad).ok());
    EXPECT_EQ(default_lift(MeshScheme::Loop, 2).sweeps, 24);
    EXPECT_EQ(default_lift(MeshScheme::Sqrt3, 40).sweeps, 64);
}

}  // namespace
}  // namespace relief::multires
